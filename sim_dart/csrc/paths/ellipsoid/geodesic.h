/* Geodesics on an ellipsoid about the origin, with its half axes along x, y and z. */
#ifndef CARDSFLOW_GEODESIC_H
#define CARDSFLOW_GEODESIC_H

#include "../../numbers/real.h"

/* Last term of a geodesic up to rounding. */
#define FINE_TERM PRECISE(1e-15, 1e-8)

/* A point of a geodesic, and the neighbouring geodesic at the distance j. */
typedef struct {
    real x[3], v[3]; /* position; direction, a unit vector */
    real j, dj;      /* Jacobi field, and its derivative by the length */
} geodesic_point;

/* Follow the geodesic by the length `way`, in steps whose last term is below `last_term`. Sizes should be
   about 1. Unless `field` is NULL, follow j and dj of another neighbouring geodesic, too. Unless `bend` is NULL,
   add the angle by which the geodesic turns. */
CORE_INSIDE void geodesic_follow(const real half_axes[3], real way, real last_term, geodesic_point *p, real field[2],
                                 real *bend);

#endif
