/* Elementary functions of numbers that carry a derivative along: f(x) + i e f'(x) dx. */
#include "support.h"
#if HAS_ALONG
#include "number.h"

/* Those of plain numbers. */
void sine_cosine(double x, double *sine, double *cosine);
double arc_tangent(double y, double x);
double arc_sine(double x);
double arc_cosine(double x);
double exponential(double x);
double exponential_less_one(double x);
double logarithm(double x);
double hyperbolic_tangent(double x);

void along_sine_cosine(real x, real *sine, real *cosine)
{
    double s, c;
    sine_cosine(value_of(x), &s, &c);
    *sine = changing(s, c * change_of(x));
    *cosine = changing(c, -s * change_of(x));
}

real along_sine(real x)
{
    real s, c;
    along_sine_cosine(x, &s, &c);
    return s;
}

real along_cosine(real x)
{
    real s, c;
    along_sine_cosine(x, &s, &c);
    return c;
}

/* At the origin, where it has no derivative, that of the constant. */
real along_arc_tangent(real y, real x)
{
    const double rr = value_of(x) * value_of(x) + value_of(y) * value_of(y);
    const double turned = value_of(x) * change_of(y) - value_of(y) * change_of(x);
    return changing(arc_tangent(value_of(y), value_of(x)), rr > 0 ? turned / rr : 0);
}

/* -1 and 1 are its ends, and there it is a constant as beyond them. */
static double arc_sine_slope(double x)
{
    const double square = (1 - x) * (1 + x);
    return square > 0 ? 1 / value_of(sqrt(square)) : 0;
}

real along_arc_sine(real x)
{
    return changing(arc_sine(value_of(x)), arc_sine_slope(value_of(x)) * change_of(x));
}

real along_arc_cosine(real x)
{
    return changing(arc_cosine(value_of(x)), -arc_sine_slope(value_of(x)) * change_of(x));
}

real along_exponential(real x)
{
    const double y = exponential(value_of(x));
    return changing(y, y * change_of(x));
}

void along_exponential_of_four(const real x[4], real y[4])
{
    for (int i = 0; i < 4; i++) y[i] = along_exponential(x[i]);
}

real along_exponential_less_one(real x)
{
    return changing(exponential_less_one(value_of(x)), exponential(value_of(x)) * change_of(x));
}

real along_logarithm(real x)
{
    return changing(logarithm(value_of(x)), change_of(x) / value_of(x));
}

real along_hyperbolic_tangent(real x)
{
    const double y = hyperbolic_tangent(value_of(x));
    return changing(y, (1 - y * y) * change_of(x));
}

#endif
