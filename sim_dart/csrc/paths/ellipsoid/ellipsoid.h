/* A cable over one ellipsoid. */
#ifndef CARDSFLOW_ELLIPSOID_H
#define CARDSFLOW_ELLIPSOID_H

#include "../cable.h"

/* As those of wrap.h; `over` leaves a straight way to its caller. Of the way the side alone counts. */
CORE_INSIDE int ellipsoid_pull(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3], pull *out);
CORE_INSIDE int ellipsoid_over(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3],
                               contact *out);
CORE_INSIDE int ellipsoid_is_clear(const wrap_surface *s, const real a[3], const real b[3]);

/* Where on the straight line, 0 to 1, it is nearest to the ellipsoid. */
CORE_INSIDE real ellipsoid_nearest(const wrap_surface *s, const real a[3], const real b[3]);

/* Whether an end is inside. */
CORE_INSIDE int ellipsoid_holds(const wrap_surface *s, const real a[3], const real b[3]);

/* The side of it, as of a way, from a direction in the world. */
CORE_INSIDE int ellipsoid_side(const wrap_surface *s, const real direction[3]);

#endif
