/* A cable over one surface. */
#ifndef CARDSFLOW_WRAP_H
#define CARDSFLOW_WRAP_H

#include "cable.h"

/* Return 1 and compute the pull if the cable touches the surface. Return 0 if it is straight from a to b;
   then only the turning angle is set. `ends` selects one or both directions; the other one may stay
   undefined. */
CORE_INSIDE int wrap_pull(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3], int ends,
                          pull *out);

CORE_INSIDE void wrap_over(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3],
                           contact *out);

/* Return whether the straight line from a to b does not meet the surface; for a path inside, whether it
   passes through the surface. */
CORE_INSIDE int wrap_is_clear(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3]);

#endif
