/* Steps of a robot that carry along how everything changes with one direction: exact derivatives.

   The core is compiled a second time for numbers x + i e dx (along/number.h), so that every formula of it is
   differentiated as it stands: wraps, pulleys, tension laws with their states, joint limits. At a kink, a
   force of zero or a joint that just meets its limit, the derivative is that of the side on which the step
   lies. Where a taut cable is found by search (several surfaces in one segment) the derivative is as good as
   that search.

   Changes are best about 1 in size: derivatives beyond 1e100 or below 1e-100 of them are lost.           */
#ifndef CARDSFLOW_ALONG_H
#define CARDSFLOW_ALONG_H

#include <stddef.h>
#include <stdint.h>

typedef struct core_along core_along;

/* Bytes of memory for a robot with a blob that core_open has taken, `plain_size` being what core_size said of
   it, and with that many loads; 0 where the compiler had no complex numbers.                           */
size_t core_along_size(const void *blob, size_t plain_size, int32_t loads);

/* Make a handle in `memory`, 8-byte aligned. */
core_along *core_along_open(const void *blob, int32_t loads, void *memory);

/* Write an array of core_array and its changes: what a step begins with, q, qd and law_states, and the
   muscles' commands, which are its input.                                                              */
void core_along_set(core_along *a, const char *array, const double *values, const double *changes);

/* How an array changes. */
void core_along_changes(core_along *a, const char *array, double *changes);

/* Load number k acts at the point of a task: a force and its change, in world axes. */
void core_along_load(core_along *a, int32_t k, int32_t task, const double force[3], const double change[3]);

/* Go to q and qd; then lengths and task_values are those there. As core_move_checked. */
int core_along_move(core_along *a);

/* As core_start, with the commands. */
int core_along_start(core_along *a);

/* As core_drive, at q and qd with the commands. */
int core_along_drive(core_along *a);

/* As core_step, with the commands and loads. */
int core_along_step(core_along *a, double h, int32_t steps);

#endif
