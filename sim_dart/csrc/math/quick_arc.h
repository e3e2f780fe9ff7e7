/* Inline arc tangent for wraps, whose run time depends on it. The result is bit-identical to arc_tangent. */
#ifndef CARDSFLOW_QUICK_ARC_H
#define CARDSFLOW_QUICK_ARC_H

#include "elementary.h"

#if defined(CARDSFLOW_TANGENT) /* arc.h is for plain numbers */

#define quick_arc_tangent arc_tangent
#define upper_arc_tangent arc_tangent

#else
#include "arc.h"

/* Compute the same as arc_tangent. */
static inline real quick_arc_tangent(real y, real x)
{
    const real a = fabs(x), b = fabs(y);
    return arc_is_moderate(b, a) ? arc_in_quadrant(arc_of(b, a), y, x) : arc_tangent(y, x);
}

#endif

#endif
