/* Where to begin the search for the way over an ellipsoid. */
#ifndef CARDSFLOW_FAN_H
#define CARDSFLOW_FAN_H

#include "../../numbers/real.h"

/* An end of the cable, and the tangents from it to the ellipsoid, which is the unit sphere once all is scaled
   by its half axes r. They touch on a circle; that of angle t goes along u(t) = r (-rho e + cos t e1 + sin t e2),
   and is rho |u| long.                                                                                   */
typedef struct {
    real at[3], distance2; /* e, scaled, and its square */
    real rho, reach;       /* radius of that circle; the tangents' length, scaled */
    real first[3], second[3]; /* e1, e2: unit vectors */
} tangent_cone;

/* A way: which tangent from each end, as cosine and sine, and how long it is on the ellipsoid. */
typedef struct {
    real a[2], b[2], contact;
} way_over;

#define MAX_STARTS 6
#define FEW_PLANES 16
#define MANY_PLANES 64

/* The cones of both ends, scaled, none of them inside. */
CORE_INSIDE void fan_cones(const real a[3], const real b[3], tangent_cone cones[2]);

/* Starts for ways that are shorter than those next to them among some planes, one of the two numbers above, the
   shortest first; returns how many.                                                                      */
CORE_INSIDE int fan_starts(const real half_axes[3], const tangent_cone cones[2], int planes,
                           way_over starts[MAX_STARTS]);

#endif
