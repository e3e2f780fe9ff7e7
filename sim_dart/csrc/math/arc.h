/* The arc tangent of numbers of moderate size. */
#ifndef CARDSFLOW_ARC_H
#define CARDSFLOW_ARC_H

#include "../numbers/real_functions.h"

#if defined(CARDSFLOW_FLOAT)
#include "arc_float.h"
#else
/* Compute (atan x - x)/x^3 by z = x^2, for |x| <= 7/16. Powers of z are computed first, so that no term
   waits for the sum of the terms before it. */
static inline real arc_polynomial(real z)
{
    const real z2 = z * z, z4 = z2 * z2;
    const real low = (-0.33333333333332926 + z * 0.1999999999987503) +
                       z2 * (-0.14285714272372965 + z * 0.11111110399576317);
    const real middle = (-0.09090886979963088 + z * 0.07691873724338298) +
                          z2 * (-0.0666104749337431 + z * 0.05833400416770279);
    const real high = (-0.04976182551012515 + z * 0.03651550949356882) + z2 * -0.01626983448084869;
    return low + z4 * (middle + z4 * high);
}

/* atan of 0, 0.5, 1, 1.5 and infinity as high + low */
static const real ARC_CORNER[5][2] = {{0, 0},
                                      {0.4636476090008061, 2.2698777452961687e-17},
                                      {0.7853981633974483, 3.061616997868383e-17},
                                      {0.982793723247329, 1.3903311031230998e-17},
                                      {1.5707963267948966, 6.123233995736766e-17}};
#endif

/* atan(b/a) = atan(q/p) + atan((p b - q a)/(p a + q b)) with the corners q/p */
static const real ARC_UNDER[5] = {1, 2, 1, 1, 0}, ARC_OVER[5] = {0, 1, 1, 1.5, 1};

/* Compute atan(b / a) for nonnegative a and b. */
static inline real arc_of(real b, real a)
{
    const int k = (b >= 0.4375 * a) + (b >= 0.6875 * a) + (b >= 1.1875 * a) + (b >= 2.4375 * a);
    const real p = ARC_UNDER[k], q = ARC_OVER[k], x = (p * b - q * a) / (p * a + q * b), z = x * x;
    return ARC_CORNER[k][0] + (x + (x * z * arc_polynomial(z) + ARC_CORNER[k][1]));
}

/* Maximum and minimum of numbers for which products do not overflow and all digits are kept. */
#define ARC_MAX PRECISE(1e300, 1e37)
#define ARC_MIN PRECISE(1e-250, 1e-30)

/* Return whether sums and products of both are finite and normal. */
static inline int arc_is_moderate(real b, real a)
{
    return (a > ARC_MIN) & (a < ARC_MAX) & (b < ARC_MAX);
}

/* Move an angle of the first quadrant to the quadrant of (x, y). */
static inline real arc_in_quadrant(real angle, real y, real x)
{
    static const real PI_HIGH = 3.141592653589793, PI_LOW = PRECISE(1.2246467991473532e-16, -8.742277657347586e-08);
    if (signbit(x)) angle = PI_HIGH - (angle - PI_LOW);
    return signbit(y) ? -angle : angle;
}

/* Compute arc_tangent of a nonnegative y, for many numbers at once: with the corners q/p of 0, 1 and
   infinity only, which needs neither a table nor a branch. The error is at most 1.4 units in the last place. */
static inline real upper_arc_tangent(real y, real x)
{
    const real a = fabs(x), p = value_of(0.4375 * y) > value_of(a) ? 0 : 1;
    const real q = value_of(y) < value_of(0.4375 * a) ? 0 : 1;
    const real part = (p * y - q * a) / (p * a + q * y), z = part * part;
    const real angle = (1 - p + q) * 0.7853981633974483 + (part + part * z * arc_polynomial(z));
    return (value_of(x) < 0 ? 3.141592653589793 : 0) + (value_of(x) < 0 ? -1 : 1) * angle;
}

#endif
