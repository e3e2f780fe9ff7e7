/* Inverse dynamics, for forward dynamics by the mass matrix. */
#ifndef CARDSFLOW_INVERSE_H
#define CARDSFLOW_INVERSE_H

#include "../blob/state.h"

/* Compute forces = C + G at the last q, with gravity only. Also compute links and velocities. */
CORE_INSIDE void inverse_fall(core *c, const real *qd, real *forces);
/* Compute matrix = M with these armatures, one value per variable. */
CORE_INSIDE void inverse_mass(core *c, const real *armature, real *matrix);

#endif
