/* Points that are fixed to frames. The functions are in this header so that they are inlined: every muscle
   uses them for all of its points. */
#ifndef CARDSFLOW_POINTS_H
#define CARDSFLOW_POINTS_H

#include "../blob/state.h"
#include "../math/vectors.h"

#include <string.h>

/* Compute the position of a point of a frame in the world; frame -1 is the world itself. */
static inline void tree_point(const core *c, int32_t frame, const real local[3], real world[3])
{
    if (frame < 0) {
        memcpy(world, local, 3 * sizeof(real));
        return;
    }
    rotate3(world, c->rotation + 9 * frame, local);
    for (int k = 0; k < 3; k++) world[k] += c->origin[3 * frame + k];
}

/* Compute the velocity of a point fixed to frame j, for unit velocity of its motion. */
static inline void tree_point_velocity(const core *c, int32_t j, const real point[3], real velocity[3])
{
    const real *axis = c->axis + 3 * j, *origin = c->origin + 3 * j;
    if (c->blob.motion[j] == TRANSLATION) {
        memcpy(velocity, axis, 3 * sizeof(real));
        return;
    }
    const real arm[3] = {point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]};
    cross3(velocity, axis, arm);
}

#endif
