/* What inertial units measure: the motion of a point on a frame. */
#ifndef CARDSFLOW_SPECIFIC_FORCE_H
#define CARDSFLOW_SPECIFIC_FORCE_H

#include "../blob/state.h"

/* Accelerations of all frames' origins, in `acceleration`, with the qdd of the core. Links and velocities are
   there: bodies_links, bodies_velocities. `rates` is room for all variables.                              */
void accelerate_frames(core *c, real *rates);

/* Acceleration less gravity, in the world, of a point at r from a frame's origin: a + alpha x r + w x (w x r) - g. */
void specific_force(const core *c, int32_t frame, const real r[3], real s[3]);

#endif
