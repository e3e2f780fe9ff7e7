/* Elementary functions: an exact reduction of the argument, then a polynomial.

   The polynomials are minimax polynomials, found by the Remez algorithm, with relative errors far below the
   rounding error. Sums are ordered so that rounded terms are small compared to the result. */
#include "arc.h"
#include "circle.h"
#include "elementary.h"
#include "polynomial.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* ------------------------------------------------------------------------------- sine and cosine */

void sine_cosine(real x, real *sine, real *cosine)
{
    circle_at(x, sine, cosine);
}

real sine(real x)
{
    real s, c;
    sine_cosine(x, &s, &c);
    return s;
}

real cosine(real x)
{
    real s, c;
    sine_cosine(x, &s, &c);
    return c;
}

/* ------------------------------------------------------------------------------------ arc tangent */

/* Compute atan(b / a) of numbers so large or so small that sums or products overflow or underflow. */
static real extreme_arc_tangent_of(real b, real a)
{
    if (isnan(a) || isnan(b)) return NAN;
    if (isinf(b)) return isinf(a) ? ARC_CORNER[2][0] : ARC_CORNER[4][0];
    return b == 0 ? 0 : arc_of(b / a, 1);
}

real arc_tangent(real y, real x)
{
    const real a = fabs(x), b = fabs(y);
    const int is_moderate = arc_is_moderate(b, a);
    if (!is_moderate && b > ARC_MAX * a) return signbit(y) ? -ARC_CORNER[4][0] : ARC_CORNER[4][0]; /* straight up */
    return arc_in_quadrant(is_moderate ? arc_of(b, a) : extreme_arc_tangent_of(b, a), y, x);
}

real arc_sine(real x)
{
    x = x < -1 ? -1 : x > 1 ? 1 : x;
    return arc_tangent(x, sqrt((1 - x) * (1 + x)));
}

real arc_cosine(real x)
{
    x = x < -1 ? -1 : x > 1 ? 1 : x;
    return arc_tangent(sqrt((1 - x) * (1 + x)), x);
}

/* ---------------------------------------------------------------------- exponential and logarithm */

static real power_of_two(int exponent) /* of a normal number */
{
    const real_bits bits = (real_bits)(exponent + EXPONENT_BIAS) << FRACTION_BITS;
    real power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

/* Compute e^x as y 2^n for |x| < about MAX_EXPONENT; `shifted` is n + WHOLE. */
static inline real exponential_parts(real x, real *shifted)
{
    *shifted = x * 1.4426950408889634 + WHOLE;
    const real n = *shifted - WHOLE;
    const real high = x - n * LN2_HIGH, low = n * LN2_LOW, r = high - low;
    const real z = r * r, c = r - z * POLYNOMIAL(z, EXP);
    return 1 - ((low - (r * c) / (2 - c)) - high);
}

/* Compute e^x for |x| < MODERATE_EXPONENT, without a branch or a conversion to an integer. */
static inline real moderate_exponential(real x)
{
    real shifted, power;
    const real y = exponential_parts(x, &shifted);
    real_bits bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + EXPONENT_BIAS) << FRACTION_BITS;
    memcpy(&power, &bits, sizeof power);
    return y * power;
}

real exponential(real x)
{
    real shifted;
    if (fabs(x) < MODERATE_EXPONENT) return moderate_exponential(x);
    if (isnan(x)) return x;
    if (x > MAX_EXPONENT) return INFINITY;
    if (x < MIN_EXPONENT) return 0;
    const real y = exponential_parts(x, &shifted);
    const int k = (int)(shifted - WHOLE); /* 2^k itself may overflow */
    return y * power_of_two(k / 2) * power_of_two(k - k / 2);
}

void exponential_of_four(const real x[4], real y[4])
{
    int is_moderate = 1;
    for (int i = 0; i < 4; i++) is_moderate &= fabs(x[i]) < MODERATE_EXPONENT;
    if (is_moderate)
        for (int i = 0; i < 4; i++) y[i] = moderate_exponential(x[i]);
    else
        for (int i = 0; i < 4; i++) y[i] = exponential(x[i]);
}

real exponential_less_one(real x)
{
    if (!(fabs(x) <= 0.68)) return exponential(x) - 1; /* loses one digit at most; also for NaN */
    const real r = fabs(x) > 0.34 ? 0.5 * x : x, z = r * r, c = r - z * POLYNOMIAL(z, EXP);
    const real m = r + r * c / (2 - c);
    return fabs(x) > 0.34 ? m * (m + 2) : m; /* (1 + m)^2 - 1 */
}

real logarithm(real x)
{
    int k = 0;
    if (!(x >= MIN_NORMAL && x <= MAX_NUMBER)) {
        if (!(x > 0)) return x == 0 ? -INFINITY : NAN;
        if (isinf(x)) return x;
        x *= RAISE, k = -RAISED;
    }
    real_bits bits;
    memcpy(&bits, &x, sizeof bits);
    k += (int)(bits >> FRACTION_BITS) - EXPONENT_BIAS;
    bits = (bits & (((real_bits)1 << FRACTION_BITS) - 1)) | (real_bits)EXPONENT_BIAS << FRACTION_BITS;
    memcpy(&x, &bits, sizeof x);
    if (x > 1.4142135623730951) x *= 0.5, k++;
    const real f = x - 1, s = f / (2 + f), z = s * s, half = 0.5 * f * f;
    const real bent = z * POLYNOMIAL(z, LOG);
    return k * LN2_HIGH - ((half - (s * (half + bent) + k * LN2_LOW)) - f);
}

real hyperbolic_tangent(real x)
{
    if (isnan(x)) return x;
    const real a = fabs(x);
    if (a < 0.4) { /* the quotient would lose digits */
        const real z = x * x;
        return x + x * z * POLYNOMIAL(z, TANH);
    }
    const real t = a > 20 ? 1 : 1 - 2 / (exponential(2 * a) + 1);
    return x < 0 ? -t : t;
}
