/* Spatial algebra, in world axes about the origin of each frame.

   Motions are (angular, linear) pairs of the frame's origin, wrenches (moment, force) about it. Between a
   frame and its parent lies a shift only, no rotation; and since the origin is the frame's own, long
   chains lose no digits to the distance from the world's origin, as they would about that.

   Accelerations are those of a stopwatch and a ruler: the linear part is the second derivative of the
   origin's position.                                                                                  */
#ifndef CARDSFLOW_SPATIAL_H
#define CARDSFLOW_SPATIAL_H

#include "../blob/state.h"
#include "../math/vectors.h"

/* The generalised force of a wrench along a frame's motion, S'w. */
static inline real generalised_force(const core *c, int32_t i, const real wrench[6])
{
    return dot3(c->axis + 3 * i, wrench + (c->blob.motion[i] == ROTATION ? 0 : 3));
}

/* Add a wrench about the origin of frame i to one about its parent's. */
static inline void add_to_parent(const core *c, int32_t i, const real wrench[6], real parent[6])
{
    add3(parent, wrench);
    add_cross3(parent, c->link + 3 * i, wrench + 3);
    add3(parent + 3, wrench + 3);
}

#endif
