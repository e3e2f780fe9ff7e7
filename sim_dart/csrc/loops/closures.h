/* Equations of loop joints: gaps, their derivatives by q, and their accelerations at qdd = 0. */
#ifndef CARDSFLOW_CLOSURES_H
#define CARDSFLOW_CLOSURES_H

#include "../blob/state.h"

/* Compute closure_gap and closure_jacobian at the last q. */
CORE_INSIDE void closures_move(core *c);
/* Compute the same, with the gaps of directions as angles. */
CORE_INSIDE void closures_angles(core *c);
/* Compute closure_bias, J' qd, after the last bodies_velocities; `acceleration` is overwritten. */
CORE_INSIDE void closures_bias(core *c);
/* Return the index of the closure with the largest gap. */
CORE_INSIDE int32_t closures_worst(const core *c);

#endif
