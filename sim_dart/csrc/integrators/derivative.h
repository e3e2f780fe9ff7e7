/* Time derivatives of the state of a robot. */
#ifndef CARDSFLOW_DERIVATIVE_H
#define CARDSFLOW_DERIVATIVE_H

#include "../blob/state.h"

/* Compute qdd and law_rates at the last q and at qd, without joint limits. Return 0, or 1 + the index of the
   first invalid command. */
CORE_INSIDE int derivative_evaluate(core *c, const real *u, const real *extra);
/* Add the work of torques, external forces and damping in a time h, after derivative_evaluate. */
CORE_INSIDE void derivative_add_work(core *c, real h);

#endif
