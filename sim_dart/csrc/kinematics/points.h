/* Points that frames carry. Here for speed: every muscle asks for all of its points, so that they are to be
   compiled into whoever asks.                                                                          */
#ifndef CARDSFLOW_POINTS_H
#define CARDSFLOW_POINTS_H

#include "../blob/state.h"
#include "../math/vectors.h"

#include <string.h>

/* Where a point of a frame is in the world; frame -1 is the world itself. */
static inline void tree_point(const core *c, int32_t frame, const real local[3], real world[3])
{
    if (frame < 0) {
        memcpy(world, local, 3 * sizeof(real));
        return;
    }
    rotate3(world, c->rotation + 9 * frame, local);
    for (int k = 0; k < 3; k++) world[k] += c->origin[3 * frame + k];
}

/* Velocity of a point that frame j carries, for unit velocity of its motion. */
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
