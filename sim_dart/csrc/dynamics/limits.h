/* Joint limits as inelastic stops. */
#ifndef CARDSFLOW_LIMITS_H
#define CARDSFLOW_LIMITS_H

#include "../blob/state.h"

/* Change qd by impulses so that all velocities are within low and high. Links and inertias must be those of
   the last q. */
CORE_INSIDE void limits_enforce(core *c);
/* Compute row j of `response`: the change of qd for a unit impulse on coordinate j. Call dynamics_factor
   first. */
CORE_INSIDE void limits_respond(core *c, int32_t j);
/* Compute the impulses that bring the first `count` coordinates in `met` from `free` to their targets; then
   qd with them. Their rows of `response` must be known. */
CORE_INSIDE void limits_solve(core *c, int32_t count);
CORE_INSIDE void limits_apply(core *c, int32_t count);

#endif
