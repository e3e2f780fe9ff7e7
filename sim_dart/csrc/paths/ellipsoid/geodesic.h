/* Geodesics on an ellipsoid about the origin, its half axes along x, y and z. */
#ifndef CARDSFLOW_GEODESIC_H
#define CARDSFLOW_GEODESIC_H

#include "../../numbers/real.h"

/* A point of a geodesic, and of its neighbour that is j away from it across. */
typedef struct {
    real x[3], v[3]; /* where it is; its direction, a unit vector */
    real j, dj;      /* Jacobi field, and its derivative by the way */
} geodesic_point;

/* Go on by `way`, in steps whose last term is that small. Sizes are best about 1. Added to `bend`, if it is not
   NULL, is by which angle it turns on the way. */
CORE_INSIDE void geodesic_follow(const real half_axes[3], real way, real last_term, geodesic_point *p, real *bend);

#endif
