/* Forward dynamics by the mass matrix: of robots with variables beside q, and while cables with friction are
   looked for. */
#ifndef CARDSFLOW_DENSE_H
#define CARDSFLOW_DENSE_H

#include "../blob/state.h"

/* Factorise M with these armatures, a number a variable. */
CORE_INSIDE void dense_factor(core *c, const real *armature);
/* x = M^-1 x, by the last factorisation. */
CORE_INSIDE void dense_solve(const core *c, real *x);
/* As core_accelerate. */
CORE_INSIDE void dense_accelerate(core *c, const real *qd, const real *tau, const real *armature);

#endif
