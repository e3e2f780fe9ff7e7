/* Forward dynamics by the mass matrix: for robots with variables other than q, and while cable friction is
   computed. */
#ifndef CARDSFLOW_DENSE_H
#define CARDSFLOW_DENSE_H

#include "../blob/state.h"

/* Factorise M with these armatures, one value per variable. */
CORE_INSIDE void dense_factor(core *c, const real *armature);
/* Compute x = M^-1 x, with the last factorisation. */
CORE_INSIDE void dense_solve(const core *c, real *x);
/* Compute the same as core_accelerate. */
CORE_INSIDE void dense_accelerate(core *c, const real *qd, const real *tau, const real *armature);

#endif
