/* Steps of semi-implicit Euler. */
#ifndef CARDSFLOW_SEMI_IMPLICIT_EULER_H
#define CARDSFLOW_SEMI_IMPLICIT_EULER_H

#include "../blob/state.h"

/* Do the same as core_step, but add to the work of the steps before. */
CORE_INSIDE int euler_steps(core *c, const real *u, const real *extra, real h, int32_t steps);

#endif
