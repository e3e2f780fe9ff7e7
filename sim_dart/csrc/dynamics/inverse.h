/* Inverse dynamics, for forward dynamics by the mass matrix. */
#ifndef CARDSFLOW_INVERSE_H
#define CARDSFLOW_INVERSE_H

#include "../blob/state.h"

/* forces = C + G at the last q, with the weight alone; links and velocities are made. */
CORE_INSIDE void inverse_fall(core *c, const real *qd, real *forces);
/* matrix = M with these armatures, a number a variable. */
CORE_INSIDE void inverse_mass(core *c, const real *armature, real *matrix);

#endif
