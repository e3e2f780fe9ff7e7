/* Quantities that all dynamics functions need, at the last q. */
#ifndef CARDSFLOW_BODIES_H
#define CARDSFLOW_BODIES_H

#include "../blob/state.h"
#include "../math/vectors.h"

#include <string.h>

/* Compute link. */
CORE_INSIDE void bodies_links(core *c);
/* Compute centre and moment. */
CORE_INSIDE void bodies_inertias(core *c);
/* Compute spin, velocity, slide and drift. */
CORE_INSIDE void bodies_velocities(core *c, const real *qd);
/* Compute the acceleration of the parent at the origin of frame i; that of the world is zero. */
static inline void bodies_parent_acceleration(const core *c, int32_t i, const real *accelerations, real out[6])
{
    const int32_t parent = c->blob.parent[i];
    if (parent < 0) {
        memset(out, 0, 6 * sizeof(real));
        return;
    }
    const real *from = accelerations + 6 * parent;
    memcpy(out, from, 6 * sizeof(real));
    add_cross3(out + 3, from, c->link + 3 * i);
}

#endif
