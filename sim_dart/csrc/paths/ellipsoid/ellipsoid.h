/* A cable over one ellipsoid. */
#ifndef CARDSFLOW_ELLIPSOID_H
#define CARDSFLOW_ELLIPSOID_H

#include "../cable.h"

/* These functions correspond to those of wrap.h, except that `over` does not handle a straight cable. Only
   the side of a `way` is used. */
CORE_INSIDE int ellipsoid_pull(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3], pull *out);
CORE_INSIDE int ellipsoid_over(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3],
                               contact *out);
CORE_INSIDE int ellipsoid_is_clear(const wrap_surface *s, const real a[3], const real b[3]);

/* Return the angle by which a cable turns that touches at `touch` in a given direction and continues on the
   ellipsoid. The component of the direction perpendicular to the surface is ignored. */
CORE_INSIDE real ellipsoid_bend(const wrap_surface *s, const real touch[3], const real direction[3], real way);
/* Compute a normal, of any length, at a point on the ellipsoid or on one of the same shape. */
CORE_INSIDE void ellipsoid_normal(const wrap_surface *s, const real touch[3], real normal[3]);

/* Return the position on the straight line, 0 to 1, nearest to the ellipsoid. */
CORE_INSIDE real ellipsoid_nearest(const wrap_surface *s, const real a[3], const real b[3]);

/* Return whether an end is inside. */
CORE_INSIDE int ellipsoid_holds(const wrap_surface *s, const real a[3], const real b[3]);

/* Return the touched half, as in a `way`, for a direction in the world. */
CORE_INSIDE int ellipsoid_side(const wrap_surface *s, const real direction[3]);

#endif
