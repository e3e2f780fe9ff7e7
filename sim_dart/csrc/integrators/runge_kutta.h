/* Steps of the Runge-Kutta method with access to their stages. */
#ifndef CARDSFLOW_RUNGE_KUTTA_H
#define CARDSFLOW_RUNGE_KUTTA_H

#include "../blob/state.h"

/* Function called at stages 0 to 3 with the rates of the stage in qd, qdd and law_rates and their weighted sum
   so far in `slopes`; for a robot with loops also at stage 4, before the loops are closed. It must not change
   these arrays, the state, `before` and `work`. */
typedef void stage_observer(void *observer, int stage, real h);

/* Do the same as core_runge_kutta, and call `observe` unless it is NULL. */
CORE_INSIDE int runge_kutta_observed(core *c, const real *u, const real *extra, real h, int32_t steps,
                                     stage_observer *observe, void *observer);

#endif
