/* A cable that runs through a surface, without turns. */
#ifndef CARDSFLOW_WRAP_INSIDE_H
#define CARDSFLOW_WRAP_INSIDE_H

#include "cable.h"

/* These functions correspond to those of wrap.h, except that `over` does not handle a straight cable. */
CORE_INSIDE int wrap_inside_pull(const wrap_surface *s, const real a[3], const real b[3], pull *out);
CORE_INSIDE int wrap_inside_over(const wrap_surface *s, const real a[3], const real b[3], contact *out);
CORE_INSIDE int wrap_inside_is_clear(const wrap_surface *s, const real a[3], const real b[3]);

#endif
