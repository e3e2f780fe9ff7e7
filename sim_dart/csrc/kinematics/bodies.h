/* What every pass over the dynamics begins with, at the last q. */
#ifndef CARDSFLOW_BODIES_H
#define CARDSFLOW_BODIES_H

#include "../blob/state.h"

/* link. */
CORE_INSIDE void bodies_links(core *c);
/* centre and moment. */
CORE_INSIDE void bodies_inertias(core *c);
/* spin, velocity, slide and drift. */
CORE_INSIDE void bodies_velocities(core *c, const real *qd);
/* What the parent's acceleration is at the origin of frame i; that of the world is zero. */
CORE_INSIDE void bodies_carry(const core *c, int32_t i, const real *accelerations, real out[6]);

#endif
