/* Spatial algebra, in world axes about the origin of each frame.

   Motions are (angular, linear) pairs at the origin of the frame, wrenches are (moment, force) pairs about
   it. The transform between a frame and its parent is a translation without rotation. Long chains lose no
   digits, since the distance to the origin of the world does not enter.

   Accelerations are classical, not spatial: the linear part is the second derivative of the position of the
   origin. */
#ifndef CARDSFLOW_SPATIAL_H
#define CARDSFLOW_SPATIAL_H

#include "../blob/state.h"
#include "../math/vectors.h"

static inline int is_zero_wrench(const real w[6])
{
    return all_of((w[0] == 0) & (w[1] == 0) & (w[2] == 0) & (w[3] == 0) & (w[4] == 0) & (w[5] == 0));
}

/* Return the generalised force of a wrench along the motion of a frame, S'w. */
static inline real generalised_force(const core *c, int32_t i, const real wrench[6])
{
    return dot3(c->axis + 3 * i, wrench + (c->blob.motion[i] == ROTATION ? 0 : 3));
}

/* Add a wrench about the origin of frame i to one about the origin of its parent. */
static inline void add_to_parent(const core *c, int32_t i, const real wrench[6], real parent[6])
{
    add3(parent, wrench);
    add_cross3(parent, c->link + 3 * i, wrench + 3);
    add3(parent + 3, wrench + 3);
}

#endif
