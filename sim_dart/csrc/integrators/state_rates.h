/* Time derivatives of the state of a robot. */
#ifndef CARDSFLOW_STATE_RATES_H
#define CARDSFLOW_STATE_RATES_H

#include "../blob/state.h"

/* Compute qdd and law_rates at the last q and at qd, without joint limits. Return 0, or 1 + the index of the
   first invalid command. */
CORE_INSIDE int state_rates_evaluate(core *c, const real *u, const real *extra);
/* Compute qdd only, with the torques of muscles in `torques`. */
CORE_INSIDE void state_rates_accelerate(core *c, const real *extra);
/* Add the work of torques, external forces and damping in a time h, after state_rates_evaluate. */
CORE_INSIDE void state_rates_add_work(core *c, real h);

#endif
