/* A number with its tangent, by a complex step: x + i e dx with e = 2^-332, about 1e-100, where dx is the
   change of x along one direction.

   Sums, products and quotients of complex numbers keep dx to rounding, as terms quadratic in e vanish in the
   rounding of x. Only at x = 0 they remain: comparisons treat numbers below 2^-500 as zero. (With an e whose
   square is less than the smallest number, processors take twice the time.) This file defines the remaining
   operations: comparisons, which use x only, and the functions of <math.h>. */
#ifndef CARDSFLOW_COMPLEX_STEP_H
#define CARDSFLOW_COMPLEX_STEP_H

#include <math.h>

#define HAS_TANGENT 1

typedef double _Complex real;

#define NEGLIGIBLE 0x1p-500

static inline double value_of(real x)
{
    const double value = __real__ x;
    return value < NEGLIGIBLE && value > -NEGLIGIBLE ? 0 : value;
}

static inline double tangent_of(real x)
{
    return __imag__ x;
}

static inline real with_tangent(double value, double tangent)
{
    real x;
    __real__ x = value;
    __imag__ x = tangent;
    return x;
}

static inline real absolute(real x)
{
    return value_of(x) < 0 ? -x : x;
}

/* The derivative at zero, where it does not exist, is zero. */
static inline real square_root(real x)
{
    const double root = sqrt(value_of(x));
    return with_tangent(root, root > 0 ? tangent_of(x) / (2 * root) : 0);
}

static inline int is_finite(real x)
{
    return isfinite(value_of(x));
}

static inline int is_not_a_number(real x)
{
    return isnan(value_of(x));
}

#undef isfinite
#undef isnan
#define isfinite is_finite
#define isnan is_not_a_number
#define fabs absolute
#define sqrt square_root
#define ceil(x) ceil(value_of(x))
#define round(x) round(value_of(x))

#endif
