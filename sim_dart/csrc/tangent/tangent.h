/* Steps of a robot with their tangent, how everything changes along one direction: exact derivatives.

   The core is compiled a second time for numbers x + i e dx (complex_step.h), so that every formula of it is
   differentiated unchanged: wraps, pulleys, muscle laws with their states, joint limits. A command at an
   end of its law's range, as the force of an ideal cable at zero, has the derivative of the range's inside: a
   cable at zero is about to pull. At other kinks, as where a joint just meets its limit, the derivative is that
   of the side on which the step lies.

   A change is best about 1 in size: those that come out beyond 1e80 or below 1e-200 are lost.            */
#ifndef CARDSFLOW_TANGENT_H
#define CARDSFLOW_TANGENT_H

#include "../core.h"
#include "support.h"

#include <stddef.h>
#include <stdint.h>

typedef struct core_tangent core_tangent;

/* Bytes of memory for a robot, and the points of it that core_external_wrenches has given. */
size_t core_tangent_size(const core *plain);

/* A handle in `memory`, 8-byte aligned, where the plain one is, with nothing that changes yet. The blob and
   the frames of external wrenches must outlive it, the plain handle need not.                               */
core_tangent *core_tangent_open(const core *plain, void *memory);

/* What a step begins with; the muscles' commands, further generalised forces, none unless they are set, and
   the external wrenches during it; what else there is at its end.                                      */
enum tangent_array {
    TANGENT_Q,
    TANGENT_QD,
    TANGENT_STATES,
    TANGENT_COMMANDS,
    TANGENT_TORQUES,
    TANGENT_WRENCHES,
    TANGENT_LENGTHS,
    TANGENT_TASKS,
    TANGENT_TENSIONS,
    TANGENT_FAR_TENSIONS,
    TANGENT_WORK,
    TANGENT_ENERGIES,
    TANGENT_MOMENTA
};

/* Write an array and its changes. */
void core_tangent_set(core_tangent *a, enum tangent_array which, const double *values, const double *changes);

/* Numbers of the robot that core_tangent_change_robot changes: the blob's real fields, one after the other. */
size_t core_tangent_robot_numbers(const core *plain);

/* Write how the robot itself changes, all but its tension laws; moves and steps after it begin with core_tangent_move. */
void core_tangent_change_robot(core_tangent *a, const double *changes);

/* The values of an array. */
void core_tangent_values(const core_tangent *a, enum tangent_array which, double *values);

/* How an array changes. */
void core_tangent_changes(const core_tangent *a, enum tangent_array which, double *changes);

/* Go to q and qd; then lengths and tasks are those there. As core_move_checked. */
int core_tangent_move(core_tangent *a);

/* As core_start, with the commands. */
int core_tangent_start(core_tangent *a);

/* As core_drive, at q and qd with the commands. */
int core_tangent_drive(core_tangent *a);

/* As core_energies, at q and qd. */
void core_tangent_energies(core_tangent *a);

/* As core_step and core_runge_kutta, with the commands, torques and external wrenches. */
int core_tangent_step(core_tangent *a, double h, int32_t steps);
int core_tangent_runge_kutta(core_tangent *a, double h, int32_t steps);

/* As one step of core_tangent_step at the last q, but q and qd alone: lengths and tasks stay those there. */
int core_tangent_advance(core_tangent *a, double h);

#endif
