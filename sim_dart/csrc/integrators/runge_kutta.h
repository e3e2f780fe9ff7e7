/* Steps of the Runge-Kutta method with access to their stages. */
#ifndef CARDSFLOW_RUNGE_KUTTA_H
#define CARDSFLOW_RUNGE_KUTTA_H

#include "../blob/state.h"
#include "../numbers/real_functions.h"

/* Weights of the rates of stages 0 to 3 in the state of each stage, then in that of the end. The implicit ones
   are those of fibres with elastic tendons; a stage with a weight of its own settles them. */
typedef struct {
    constant explicit_weights[5][4], implicit_weights[5][4];
} stage_table;

/* Store the state, or its rates. */
CORE_INSIDE void runge_kutta_store(const core *c, const real *q, const real *qd, const real *states, real *to);

/* Return the table of a step of h. */
CORE_INSIDE const stage_table *runge_kutta_stages(const core *c, real h);

/* Function called at stages 0 to 3 with the rates of the stages so far in `stage_rates`; for a robot with
   loops also at stage 4, before the loops are closed. It must not change the state, its rates and work. */
typedef void stage_observer(void *observer, int stage, real h);

/* Do the same as core_runge_kutta, and call `observe` unless it is NULL. */
CORE_INSIDE int runge_kutta_observed(core *c, const real *u, const real *extra, real h, int32_t steps,
                                     stage_observer *observe, void *observer);

#endif
