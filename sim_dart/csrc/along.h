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

/* Bytes of memory for a robot of which that many points are pushed. */
size_t core_along_size(const core *plain, int32_t pushes);

/* A handle in `memory`, 8-byte aligned, where the plain one is, with nothing that changes yet. The blob must
   outlive it, the plain handle need not.                                                               */
core_along *core_along_open(const core *plain, int32_t pushes, void *memory);

/* What a step begins with, and the muscles' commands during it; then what else there is at its end. */
enum along_array { ALONG_Q, ALONG_QD, ALONG_STATES, ALONG_COMMANDS, ALONG_LENGTHS, ALONG_TASKS, ALONG_TENSIONS };

/* Write an array and its changes. */
void core_along_set(core_along *a, enum along_array which, const double *values, const double *changes);

/* How an array changes. */
void core_along_changes(const core_along *a, enum along_array which, double *changes);

/* From now on push number k acts at the point of a task: a force and its change, in world axes. */
void core_along_load(core_along *a, int32_t k, int32_t task, const double force[3], const double change[3]);

/* Go to q and qd; then lengths and tasks are those there. As core_move_checked. */
int core_along_move(core_along *a);

/* As core_start, with the commands. */
int core_along_start(core_along *a);

/* As core_drive, at q and qd with the commands. */
int core_along_drive(core_along *a);

/* As core_step and core_runge_kutta, with the commands and pushes. */
int core_along_step(core_along *a, double h, int32_t steps);
int core_along_runge_kutta(core_along *a, double h, int32_t steps);

#endif
