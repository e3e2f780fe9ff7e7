/* A cable led through a surface, which has no turns. */
#ifndef CARDSFLOW_WRAP_INSIDE_H
#define CARDSFLOW_WRAP_INSIDE_H

#include "cable.h"

/* As those of wrap.h; `over` leaves a straight way to its caller. */
CORE_INSIDE int wrap_inside_pull(const wrap_surface *s, const real a[3], const real b[3], pull *out);
CORE_INSIDE int wrap_inside_over(const wrap_surface *s, const real a[3], const real b[3], contact *out);
CORE_INSIDE int wrap_inside_is_clear(const wrap_surface *s, const real a[3], const real b[3]);

#endif
