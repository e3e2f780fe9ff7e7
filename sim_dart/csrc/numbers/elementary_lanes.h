/* Elementary functions of several numbers. Included by elementary.h. */
#ifndef CARDSFLOW_ELEMENTARY_LANES_H
#define CARDSFLOW_ELEMENTARY_LANES_H

#include "../math/circle.h"

/* Functions of plain numbers. */
double arc_tangent(double y, double x);
double arc_sine(double x);

static inline real lanes_arc_tangent(real y, real x)
{
    for (int i = 0; i < GROUP; i++) x[i] = arc_tangent(y[i], x[i]);
    return x;
}

static inline real lanes_arc_sine(real x)
{
    for (int i = 0; i < GROUP; i++) x[i] = arc_sine(x[i]);
    return x;
}

#define sine_cosine circle_at
#define arc_tangent lanes_arc_tangent
#define arc_sine lanes_arc_sine

#endif
