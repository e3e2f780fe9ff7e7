/* Starts of the search for the path over an ellipsoid. */
#ifndef CARDSFLOW_FAN_H
#define CARDSFLOW_FAN_H

#include "../../numbers/real.h"

/* An end of the cable, and the tangents from it to the ellipsoid, which is the unit sphere after scaling by
   its half axes r. The tangents touch on a circle. The tangent of angle t has the direction u(t) = r (-rho e
   + cos t e1 + sin t e2) and the length rho |u|. */
typedef struct {
    real at[3], distance, distance2; /* e, scaled, its length, and the square of it */
    real rho, reach;       /* radius of that circle; length of the tangents, scaled */
    real first[3], second[3]; /* e1, e2: unit vectors */
} tangent_cone;

/* A path: cosine and sine of the tangent from each end, and the length on the ellipsoid. */
typedef struct {
    real a[2], b[2], contact;
} path_over;

#define MAX_STARTS 6
#define FEW_PLANES 16
#define MANY_PLANES 64

/* Compute the cones of both ends, scaled; neither end may be inside. */
CORE_INSIDE void fan_cones(const real a[3], const real b[3], tangent_cone cones[2]);

/* Find paths that are shorter than their neighbours among a number of planes, which is one of the two
   numbers above; shortest first. Return the number of paths. */
CORE_INSIDE int fan_starts(const real half_axes[3], const tangent_cone cones[2], int planes,
                           path_over starts[MAX_STARTS]);

#endif
