/* What loop joints hold: gaps, their derivatives by q, and their accelerations at qdd = 0. */
#ifndef CARDSFLOW_CLOSURES_H
#define CARDSFLOW_CLOSURES_H

#include "../blob/state.h"

/* closure_gap and closure_jacobian at the last q. */
CORE_INSIDE void closures_move(core *c);
/* The same, with directions as the angles that they are off by. */
CORE_INSIDE void closures_angles(core *c);
/* closure_bias, J' qd, after the last bodies_velocities; `acceleration` is spent. */
CORE_INSIDE void closures_bias(core *c);
/* The largest gap: which closure's. */
CORE_INSIDE int32_t closures_worst(const core *c);

#endif
