/* A number with its tangent, by a complex step: x + i e dx with e = 2^-332, about 1e-100, where dx is how x
   changes along one direction.

   Sums, products and quotients of complex numbers keep dx to rounding, as what is quadratic in e is lost in
   the rounding of x. Only where x is zero it is not: comparisons take what is below 2^-500 for zero. (With an
   e whose square is less than the smallest number, processors take twice the time.) What is left is said
   here: comparisons, which look at x, and what <math.h> has.                                           */
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

/* At zero, if it has no derivative, that of the constant. */
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
