/* Intervals of a motion with their derivatives, for multiple shooting. */
#ifndef CARDSFLOW_SHOOTING_H
#define CARDSFLOW_SHOOTING_H

#include "../core.h"
#include "support.h"

typedef struct core_shooting core_shooting;

/* Return the size of memory in bytes for a robot; 0 if derivatives are not supported, see support.h, or if
   cables have friction. */
CORE_API size_t core_shooting_size(const core *plain);

/* Create a handle in `memory`, which is 8-byte aligned; see core_tangent_open. The plain handle must outlive
   it, and its state changes. Return NULL if derivatives are not supported. */
CORE_API core_shooting *core_shooting_open(core *plain, void *memory);

/* Simulate `count` intervals, each with steps[k] Runge-Kutta steps of h[k] and constant controls. The state of
   an interval is q, qd and law_states; its controls are the commands of all muscles and the external
   generalised forces. Inputs are the state, the controls, and h, in this order. Compute the states at the
   ends, count x states, and their derivatives by the given inputs, count x states x directions. Without
   directions only the ends are computed, which is much faster. Derivatives do not include joint limits that
   are reached. Return 0, or 1 + the interval in which the state diverged. */
CORE_API int core_shooting_run(core_shooting *s, int32_t count, const int32_t *steps, const double *h, const double *starts,
                               const double *controls, int32_t directions, const int32_t *inputs, double *ends,
                               double *derivatives);

/* Compute the time derivatives, count x states, and the tensions of all muscles, count x muscles, at states with
   their controls. This function and the next one only exist if derivatives are supported. Return 0, or 1 + the index
   of a state that is not finite. */
CORE_API int core_shooting_rates(core_shooting *s, int32_t count, const double *states, const double *controls,
                                 double *rates, double *tensions);

/* Compute the derivatives of the states at the ends, count x states, along a change of the numbers of the
   robot's blob, in the order of its fields: see core_tangent_change_robot. Return the same as
   core_shooting_run. */
CORE_API int core_shooting_along(core_shooting *s, int32_t count, const int32_t *steps, const double *h,
                                 const double *starts, const double *controls, const double *robot_changes,
                                 double *derivatives);

#endif
