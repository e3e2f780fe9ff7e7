/* A cable over one ellipsoid. */
#ifndef CARDSFLOW_ELLIPSOID_H
#define CARDSFLOW_ELLIPSOID_H

#include "../cable.h"

/* As those of wrap.h; `over` leaves a straight way to its caller. Of the way the side alone counts. */
CORE_INSIDE int ellipsoid_pull(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3], pull *out);
CORE_INSIDE int ellipsoid_over(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3],
                               contact *out);
CORE_INSIDE int ellipsoid_is_clear(const wrap_surface *s, const real a[3], const real b[3]);

/* By which angle a cable turns on it that touches there, in a direction whose part across the surface does not
   count, and goes that way on it. */
CORE_INSIDE real ellipsoid_bend(const wrap_surface *s, const real touch[3], const real direction[3], real way);
/* A normal of it, of any length, at a point on it, or on one of the same shape. */
CORE_INSIDE void ellipsoid_normal(const wrap_surface *s, const real touch[3], real normal[3]);

/* Where on the straight line, 0 to 1, it is nearest to the ellipsoid. */
CORE_INSIDE real ellipsoid_nearest(const wrap_surface *s, const real a[3], const real b[3]);

/* Whether an end is inside. */
CORE_INSIDE int ellipsoid_holds(const wrap_surface *s, const real a[3], const real b[3]);

/* The side of it, as of a way, from a direction in the world. */
CORE_INSIDE int ellipsoid_side(const wrap_surface *s, const real direction[3]);

#endif
