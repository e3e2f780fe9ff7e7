/* Steps of a robot that carry along how everything changes with one direction: exact derivatives.

   The core is compiled a second time for numbers x + i e dx (along/number.h), so that every formula of it is
   differentiated as it stands: wraps, pulleys, tension laws with their states, joint limits. At a kink, a
   force of zero or a joint that just meets its limit, the derivative is that of the side on which the step
   lies.

   A change is best about 1 in size: those that come out beyond 1e80 or below 1e-200 are lost.            */
#ifndef CARDSFLOW_ALONG_H
#define CARDSFLOW_ALONG_H

#include "core.h"

#include <stddef.h>
#include <stdint.h>

typedef struct core_along core_along;

/* Bytes of memory for a robot, and the points of it that core_push has given. */
size_t core_along_size(const core *plain);

/* A handle in `memory`, 8-byte aligned, where the plain one is, with nothing that changes yet. The blob and
   the frames that are pushed must outlive it, the plain handle need not.                               */
core_along *core_along_open(const core *plain, void *memory);

/* What a step begins with; the muscles' commands and the wrenches of what is pushed during it; what else there
   is at its end.                                                                                       */
enum along_array {
    ALONG_Q,
    ALONG_QD,
    ALONG_STATES,
    ALONG_COMMANDS,
    ALONG_PUSHES,
    ALONG_LENGTHS,
    ALONG_TASKS,
    ALONG_TENSIONS,
    ALONG_WORK,
    ALONG_ENERGIES,
    ALONG_MOMENTA
};

/* Write an array and its changes. */
void core_along_set(core_along *a, enum along_array which, const double *values, const double *changes);

/* How an array changes. */
void core_along_changes(const core_along *a, enum along_array which, double *changes);

/* Go to q and qd; then lengths and tasks are those there. As core_move_checked. */
int core_along_move(core_along *a);

/* As core_start, with the commands. */
int core_along_start(core_along *a);

/* As core_drive, at q and qd with the commands. */
int core_along_drive(core_along *a);

/* As core_energies, at q and qd. */
void core_along_energies(core_along *a);

/* As core_step and core_runge_kutta, with the commands and pushes. */
int core_along_step(core_along *a, double h, int32_t steps);
int core_along_runge_kutta(core_along *a, double h, int32_t steps);

#endif
