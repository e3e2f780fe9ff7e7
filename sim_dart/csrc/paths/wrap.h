/* A cable over one surface. */
#ifndef CARDSFLOW_WRAP_H
#define CARDSFLOW_WRAP_H

#include "cable.h"

/* 1 and the pull where the cable touches the surface; 0 if it runs straight from a to b: then only the
   turning is set. Of `ends`, both directions or one; the other may be left as it is.                    */
CORE_INSIDE int wrap_pull(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3], int ends,
              pull *out);

CORE_INSIDE void wrap_over(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3],
               contact *out);

/* Whether the straight line from a to b clears the surface; or, for a way inside, passes through it. */
CORE_INSIDE int wrap_is_clear(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3]);

#endif
