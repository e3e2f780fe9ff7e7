/* Steps of a robot with their tangent, the change of all quantities along one direction: exact derivatives.

   The core is compiled a second time for numbers x + i e dx (complex_step.h), so that all its formulas are
   differentiated unchanged: wraps, pulleys, muscle laws with their states, joint limits. For a command at an
   end of the range of its law, such as the force 0 of an ideal cable, the derivative is the one inside of
   the range. At other kinks, for example a joint that just reaches its limit, the derivative is the one on
   the side of the step.

   A change should be about 1 in size: results above 1e80 or below 1e-200 are lost. */
#ifndef CARDSFLOW_TANGENT_H
#define CARDSFLOW_TANGENT_H

#include "../../generated/law_parameters.h"
#include "../core.h"
#include "support.h"

#include <stddef.h>
#include <stdint.h>

typedef struct core_tangent core_tangent;

/* Return the size of memory in bytes for a robot and the points of its core_external_wrenches. */
size_t core_tangent_size(const core *plain);

/* Create a handle in `memory`, which is 8-byte aligned, at the state of the plain handle, with all changes
   zero. The blob and the frames of external wrenches must outlive it; the plain handle may be closed. */
core_tangent *core_tangent_open(const core *plain, void *memory);

/* Start state of a step; commands of muscles, external generalised forces (default: 0), external wrenches
   during the step; further results at its end. Accelerations, rates of states and forces on held coordinates
   are results of core_tangent_derivative only. */
enum tangent_array {
    TANGENT_Q,
    TANGENT_QD,
    TANGENT_QDD,
    TANGENT_HELD,
    TANGENT_HOLD_FORCES,
    TANGENT_STATES,
    TANGENT_STATE_RATES,
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

/* Return the number of reals that core_tangent_change_robot changes: the real fields of the blob, in order. */
size_t core_tangent_robot_numbers(const core *plain);

/* Set the change of the robot itself. Call core_tangent_move before further moves and steps. */
void core_tangent_change_robot(core_tangent *a, const double *changes);

/* Read the values of an array. */
void core_tangent_values(const core_tangent *a, enum tangent_array which, double *values);

/* Read the changes of an array. */
void core_tangent_changes(const core_tangent *a, enum tangent_array which, double *changes);

/* Move to q and qd, including lengths and tasks. Return the same as core_move_checked. */
int core_tangent_move(core_tangent *a);

/* Do the same as core_start, with the commands. */
int core_tangent_start(core_tangent *a);

/* Do the same as core_drive, at q and qd with the commands. */
int core_tangent_drive(core_tangent *a);

/* Do the same as core_energies, at q and qd. */
void core_tangent_energies(core_tangent *a);

/* Do the same as core_step or core_runge_kutta, with the commands, torques and external wrenches. */
int core_tangent_step(core_tangent *a, double h, int32_t steps);
int core_tangent_runge_kutta(core_tangent *a, double h, int32_t steps);

/* Do the same as core_derivative, with the commands, torques and external wrenches. */
int core_tangent_derivative(core_tangent *a);

/* Do one step of core_tangent_step at the last q, but advance only q and qd: lengths and tasks do not
   change. */
int core_tangent_advance(core_tangent *a, double h);

/* ---- Parts of the derivatives of rates, see rate_jacobian.h. All arrays have one number per coordinate or
   muscle, without strides. ---- */

/* Derivatives of a muscle: rows are its tension and the rates of its states; columns are these inputs. Last is
   the number of states. */
enum { LAW_BY_LENGTH, LAW_BY_RATE, LAW_BY_COMMAND, LAW_BY_STATES, LAW_INPUTS = LAW_BY_STATES + MAX_LAW_STATES };
enum { LAW_STATE_COUNT = (1 + MAX_LAW_STATES) * LAW_INPUTS, LAW_PARTIALS };

/* Copy the state of the plain handle after state_rates_evaluate, without changes. The tree has moved to it;
   the paths only if cables have a weight. */
void core_tangent_place(core_tangent *a, const core *plain, const double *commands, const double *torques);

/* Compute the derivatives of all muscles, muscles x LAW_PARTIALS, after core_tangent_place. Those of a heavy
   cable by its length are 0, and those of the rate of a fibre in a step that settles it. */
void core_tangent_laws(core_tangent *a, double *partials);

/* Compute the change of the torques along the command of a heavy cable by its weight, else 0, after
   core_tangent_place. */
void core_tangent_weight_along_command(core_tangent *a, size_t muscle, double *torques);

/* Compute the change of qdd along a velocity, after core_tangent_place, with constant tensions. */
void core_tangent_accelerate_along_qd(core_tangent *a, size_t coordinate, double *qdd);

/* Compute the changes of qdd, with constant tensions, and of the rates of paths along a coordinate. The tree
   and the paths then have changes. The tension of a heavy cable changes with its position. */
void core_tangent_accelerate_along_q(core_tangent *a, size_t coordinate, double *qdd, double *rates);

/* Compute the changes of q and qd after loops_close, from the state of the plain handle, along input j of q
   and qd. */
void core_tangent_close_along(core_tangent *a, const core *plain, size_t j, double *state);

#endif
