/* Responses to impulses, by articulated bodies. */
#ifndef CARDSFLOW_FORWARD_H
#define CARDSFLOW_FORWARD_H

#include "../blob/state.h"

/* Factorise M with these armatures; links, inertias and velocities must be those of the last q. */
CORE_INSIDE void dynamics_factor(core *c, const real *armature);
/* Compute qdd of the tree without loops, as core_accelerate does; also factorise M. */
CORE_INSIDE void dynamics_accelerate(core *c, const real *qd, const real *tau, const real *armature);
/* Compute change = M^-1 impulse, with the articulated bodies of the last factorisation. */
CORE_INSIDE void dynamics_respond(core *c, const real *impulse, real *change);

#endif
