/* Quantities that all dynamics functions need, at the last q. */
#ifndef CARDSFLOW_BODIES_H
#define CARDSFLOW_BODIES_H

#include "../blob/state.h"

/* Compute link. */
CORE_INSIDE void bodies_links(core *c);
/* Compute centre and moment. */
CORE_INSIDE void bodies_inertias(core *c);
/* Compute spin, velocity, slide and drift. */
CORE_INSIDE void bodies_velocities(core *c, const real *qd);
/* Compute the acceleration of the parent at the origin of frame i; that of the world is zero. */
CORE_INSIDE void bodies_parent_acceleration(const core *c, int32_t i, const real *accelerations, real out[6]);

#endif
