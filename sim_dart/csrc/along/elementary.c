/* Elementary functions of numbers that carry a derivative along: f(x) + i e f'(x) dx. */
#include "../elementary.h"

#include <math.h>

typedef double _Complex along;

static inline along changing(double value, double change)
{
    along x;
    __real__ x = value;
    __imag__ x = change;
    return x;
}

#define VALUE(x) (__real__(x))
#define CHANGE(x) (__imag__(x))

void along_sine_cosine(along x, along *sine, along *cosine)
{
    double s, c;
    sine_cosine(VALUE(x), &s, &c);
    *sine = changing(s, c * CHANGE(x));
    *cosine = changing(c, -s * CHANGE(x));
}

along along_sine(along x)
{
    along s, c;
    along_sine_cosine(x, &s, &c);
    return s;
}

along along_cosine(along x)
{
    along s, c;
    along_sine_cosine(x, &s, &c);
    return c;
}

/* At the origin, where it has no derivative, that of the constant. */
along along_arc_tangent(along y, along x)
{
    const double rr = VALUE(x) * VALUE(x) + VALUE(y) * VALUE(y);
    const double turned = VALUE(x) * CHANGE(y) - VALUE(y) * CHANGE(x);
    return changing(arc_tangent(VALUE(y), VALUE(x)), rr > 0 ? turned / rr : 0);
}

/* -1 and 1 are its ends, and there it is a constant as beyond them. */
static double arc_sine_slope(double x)
{
    const double square = (1 - x) * (1 + x);
    return square > 0 ? 1 / sqrt(square) : 0;
}

along along_arc_sine(along x)
{
    return changing(arc_sine(VALUE(x)), arc_sine_slope(VALUE(x)) * CHANGE(x));
}

along along_arc_cosine(along x)
{
    return changing(arc_cosine(VALUE(x)), -arc_sine_slope(VALUE(x)) * CHANGE(x));
}

along along_exponential(along x)
{
    const double y = exponential(VALUE(x));
    return changing(y, y * CHANGE(x));
}

void along_exponential_of_four(const along x[4], along y[4])
{
    for (int i = 0; i < 4; i++) y[i] = along_exponential(x[i]);
}

along along_exponential_less_one(along x)
{
    return changing(exponential_less_one(VALUE(x)), exponential(VALUE(x)) * CHANGE(x));
}

along along_logarithm(along x)
{
    return changing(logarithm(VALUE(x)), CHANGE(x) / VALUE(x));
}

along along_hyperbolic_tangent(along x)
{
    const double y = hyperbolic_tangent(VALUE(x));
    return changing(y, (1 - y * y) * CHANGE(x));
}
