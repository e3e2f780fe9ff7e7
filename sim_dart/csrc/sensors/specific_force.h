/* Measurements of IMUs: the motion of a point on a frame. */
#ifndef CARDSFLOW_SPECIFIC_FORCE_H
#define CARDSFLOW_SPECIFIC_FORCE_H

#include "../blob/state.h"

/* Compute the accelerations of the origins of all frames, in `acceleration`, with the qdd of the core. Call
   bodies_links and bodies_velocities first. `rates` is working memory for all variables. */
void accelerate_frames(core *c, real *rates);

/* Compute the acceleration minus gravity, in the world, of a point at r from the origin of a frame: a +
   alpha x r + w x (w x r) - g. */
void specific_force(const core *c, int32_t frame, const real r[3], real s[3]);

#endif
