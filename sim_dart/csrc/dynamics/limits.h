/* Joint limits as inelastic stops. */
#ifndef CARDSFLOW_LIMITS_H
#define CARDSFLOW_LIMITS_H

#include "../blob/state.h"

/* Change qd by impulses so that all velocities are within low and high; links and inertias are those of
   the last q. */
CORE_INSIDE void limits_keep(core *c);
/* What a unit impulse on coordinate j does to qd, into `response`; after dynamics_factor. */
CORE_INSIDE void limits_respond(core *c, int32_t j);
/* The impulses of the first `count` coordinates in `met` that bring each from `free` to its target; then
   qd with them. Their rows of `response` are known. */
CORE_INSIDE void limits_solve(core *c, int32_t count);
CORE_INSIDE void limits_apply(core *c, int32_t count);

#endif
