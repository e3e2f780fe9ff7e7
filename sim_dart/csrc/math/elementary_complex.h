/* Elementary functions of numbers with a tangent: f(x) + i e f'(x) dx. Included by elementary.h. */
#ifndef CARDSFLOW_ELEMENTARY_COMPLEX_H
#define CARDSFLOW_ELEMENTARY_COMPLEX_H

#include "../numbers/real_functions.h"

/* Functions of plain numbers. */
void sine_cosine(double x, double *sine, double *cosine);
double arc_tangent(double y, double x);
double arc_sine(double x);
double arc_cosine(double x);
double exponential(double x);
double exponential_less_one(double x);
double logarithm(double x);
double hyperbolic_tangent(double x);

static inline void complex_sine_cosine(real x, real *sine, real *cosine)
{
    double s, c;
    sine_cosine(value_of(x), &s, &c);
    *sine = with_tangent(s, c * tangent_of(x));
    *cosine = with_tangent(c, -s * tangent_of(x));
}

static inline real complex_sine(real x)
{
    real s, c;
    complex_sine_cosine(x, &s, &c);
    return s;
}

static inline real complex_cosine(real x)
{
    real s, c;
    complex_sine_cosine(x, &s, &c);
    return c;
}

/* The derivative at the origin, where it does not exist, is zero. */
static inline real complex_arc_tangent(real y, real x)
{
    const double rr = value_of(x) * value_of(x) + value_of(y) * value_of(y);
    const double turned = value_of(x) * tangent_of(y) - value_of(y) * tangent_of(x);
    return with_tangent(arc_tangent(value_of(y), value_of(x)), rr > 0 ? turned / rr : 0);
}

/* Return the derivative. At -1 and 1 it is zero, as outside of this range. */
static inline double arc_sine_slope(double x)
{
    const double square = (1 - x) * (1 + x);
    return square > 0 ? 1 / value_of(sqrt(square)) : 0;
}

static inline real complex_arc_sine(real x)
{
    return with_tangent(arc_sine(value_of(x)), arc_sine_slope(value_of(x)) * tangent_of(x));
}

static inline real complex_arc_cosine(real x)
{
    return with_tangent(arc_cosine(value_of(x)), -arc_sine_slope(value_of(x)) * tangent_of(x));
}

static inline real complex_exponential(real x)
{
    const double y = exponential(value_of(x));
    return with_tangent(y, y * tangent_of(x));
}

static inline void complex_exponential_of_four(const real x[4], real y[4])
{
    for (int i = 0; i < 4; i++) y[i] = complex_exponential(x[i]);
}

static inline real complex_exponential_less_one(real x)
{
    return with_tangent(exponential_less_one(value_of(x)), exponential(value_of(x)) * tangent_of(x));
}

static inline real complex_logarithm(real x)
{
    return with_tangent(logarithm(value_of(x)), tangent_of(x) / value_of(x));
}

static inline real complex_hyperbolic_tangent(real x)
{
    const double y = hyperbolic_tangent(value_of(x));
    return with_tangent(y, (1 - y * y) * tangent_of(x));
}

#define sine_cosine complex_sine_cosine
#define sine complex_sine
#define cosine complex_cosine
#define arc_tangent complex_arc_tangent
#define arc_sine complex_arc_sine
#define arc_cosine complex_arc_cosine
#define exponential complex_exponential
#define exponential_of_four complex_exponential_of_four
#define exponential_less_one complex_exponential_less_one
#define logarithm complex_logarithm
#define hyperbolic_tangent complex_hyperbolic_tangent

#endif
