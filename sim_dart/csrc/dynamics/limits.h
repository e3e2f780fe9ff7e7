/* Joint limits as inelastic stops. */
#ifndef CARDSFLOW_LIMITS_H
#define CARDSFLOW_LIMITS_H

#include "../blob/state.h"

/* Change the rates, qd or qdd, by impulses or forces so that all of them are within low and high. Links and
   inertias must be those of the last q. `side` contains the active limits. */
CORE_INSIDE void limits_enforce(core *c, real *rates);
/* Do the same for qd at the end of a step h, with soft limits. */
CORE_INSIDE void limits_enforce_softly(core *c, real h);
/* Set coordinates that are beyond a limit, or `held`, to the limit, and stop them by impulses; moves the
   handle. */
CORE_INSIDE void limits_stop(core *c);
/* Compute row j of `response`: the change of qd for a unit impulse on coordinate j. Call dynamics_factor
   first. */
CORE_INSIDE void limits_respond(core *c, int32_t j);
/* Compute the impulses that bring the first `count` coordinates in `met` from `free` to their targets; then
   the rates with them. Their rows of `response` must be known. */
CORE_INSIDE void limits_solve(core *c, int32_t count);
CORE_INSIDE void limits_apply(core *c, int32_t count, real *rates);

#endif
