/* Elementary functions: an exact reduction of the argument, then a polynomial.

   The polynomials are minimax ones, found by Remez' algorithm for relative errors below 5e-18. Sums are
   arranged so that what is rounded is small against the result.                                        */
#include "arc.h"
#include "elementary.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#define POLYNOMIAL(z, c) polynomial(z, c, sizeof c / sizeof *c)

/* Horner's scheme for even and odd powers apart: two short chains that a processor works on at once. */
static inline real polynomial(real z, const real *c, size_t count)
{
    const size_t last = (count - 1) / 2;
    const real zz = z * z;
    real even = c[2 * last], odd = 2 * last + 1 < count ? c[2 * last + 1] : 0;
    for (size_t k = last; k-- > 0;) even = even * zz + c[2 * k], odd = odd * zz + c[2 * k + 1];
    return even + z * odd;
}

/* ------------------------------------------------------------------------------- sine and cosine */

/* pi/2 in parts of 22 bits, so that multiples below 2^31 of all but the last are exact. */
static const real QUARTER[4] = {1.570796012878418, 3.139164164167596e-07, 6.223371969669989e-14,
                                2.0222662487959506e-21};
static const real TURNS = 0.6366197723675814; /* 2/pi */

/* (sin x - x)/x^3 and (cos x - 1 + x^2/2)/x^4 by x^2, for |x| <= pi/4 */
static const real SINE[] = {-0.16666666666666632,    0.008333333333322372,    -0.0001984126982977151,
                            2.7557313678691495e-06, -2.5050755954726174e-08, 1.5896665643172655e-10};
static const real COSINE[] = {0.0416666666666666,     -0.0013888888888874066, 2.4801587289444864e-05,
                              -2.75573143410594e-07, 2.0875721678381953e-09, -1.1359562171885525e-11};

/* x less the nearest multiple of pi/2, as high + low; the multiple, modulo 4. */
static int reduce(real x, real *high, real *low)
{
    real n = x * TURNS, rest = x, lost = 0;
    n = (real)(int64_t)(n < 0 ? n - 0.5 : n + 0.5);
    for (int k = 0; k < 4; k++) { /* Knuth's two-sum keeps what each subtraction loses */
        const real part = -n * QUARTER[k], sum = rest + part, back = sum - rest;
        lost += (rest - (sum - back)) + (part - back);
        rest = sum;
    }
    *high = rest + lost;
    *low = (rest - *high) + lost;
    return (int)((int64_t)n & 3);
}

/* of high + low, |high + low| <= pi/4 */
static real small_sine(real high, real low)
{
    const real z = high * high;
    return high + (z * high * POLYNOMIAL(z, SINE) + low * (1 - 0.5 * z));
}

static real small_cosine(real high, real low)
{
    const real z = high * high, half = 0.5 * z, w = 1 - half;
    return w + (((1 - w) - half) + (z * z * POLYNOMIAL(z, COSINE) - high * low));
}

/* Not a number for what is not finite. */
void sine_cosine(real x, real *sine, real *cosine)
{
    real high, low = 0;
    int quarter = 0;
    if (!(fabs(x) <= 1e9)) x = fmod(x, 6.283185307179586); /* further than any robot turns */
    high = x;
    if (fabs(x) > 0.785) quarter = reduce(x, &high, &low);
    const real s = small_sine(high, low), c = small_cosine(high, low);
    *sine = quarter == 0 ? s : quarter == 1 ? c : quarter == 2 ? -s : -c;
    *cosine = quarter == 0 ? c : quarter == 1 ? -s : quarter == 2 ? -c : s;
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

/* Of numbers so large or so small that a sum or a product of theirs may not be one. */
static real extreme_arc_tangent_of(real b, real a)
{
    if (isnan(a) || isnan(b)) return NAN;
    if (isinf(a) && isinf(b)) return ARC_CORNER[2][0];
    return b == 0 ? 0 : arc_of(b / a, 1);
}

real arc_tangent(real y, real x)
{
    const real a = fabs(x), b = fabs(y);
    const int is_moderate = arc_is_moderate(b, a);
    if (!is_moderate && b > 1e300 * a) return signbit(y) ? -ARC_CORNER[4][0] : ARC_CORNER[4][0]; /* straight up */
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

static const real LN2_HIGH = 0.6931471803691238, LN2_LOW = 1.9082149292705877e-10; /* 32 bits + rest */

/* (r (e^r + 1)/(e^r - 1) - 2)/r^2 by r^2, for |r| <= ln(2)/2 */
static const real EXP[] = {0.166666666666666, -0.002777777777698507, 6.613756312760736e-05,
                           -1.6533892597968386e-06, 4.137774110612632e-08};

/* (ln((1 + s)/(1 - s)) - 2s)/s^3 by s^2, for 1 + f within sqrt(1/2) and sqrt(2), s = f/(2 + f) */
static const real LOG[] = {0.666666666666674,  0.39999999999378016, 0.2857142875130177, 0.22222197586901452,
                           0.1818361903429931, 0.15312568241503632, 0.14811560129883308};

/* (tanh x - x)/x^3 by x^2, for |x| <= 0.4 */
static const real TANH[] = {-0.3333333333333333,    0.13333333333332628,   -0.0539682539675065,
                            0.02186948849693757,    -0.008863234346172966, 0.00359210589232848,
                            -0.0014555686280255324, 0.000587971111313554,  -0.00022913508403632726,
                            6.856938213882136e-05};

/* Added to a number below 2^51, it leaves the nearest whole one in the last bits, rounded as sums are. */
static const real WHOLE = 6755399441055744.0; /* 2^52 + 2^51 */

static real power_of_two(int exponent) /* within -1022 to 1023 */
{
    const uint64_t bits = (uint64_t)(exponent + 1023) << 52;
    real power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

/* e^x as y 2^n, of |x| < 1000; n + WHOLE */
static inline real exponential_parts(real x, real *shifted)
{
    *shifted = x * 1.4426950408889634 + WHOLE;
    const real n = *shifted - WHOLE;
    const real high = x - n * LN2_HIGH, low = n * LN2_LOW, r = high - low;
    const real z = r * r, c = r - z * POLYNOMIAL(z, EXP);
    return 1 - ((low - (r * c) / (2 - c)) - high);
}

/* Of |x| < 700, without a branch or an integer that has to be converted. */
static inline real moderate_exponential(real x)
{
    real shifted, power;
    const real y = exponential_parts(x, &shifted);
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 1023) << 52;
    memcpy(&power, &bits, sizeof power);
    return y * power;
}

real exponential(real x)
{
    real shifted;
    if (fabs(x) < 700) return moderate_exponential(x);
    if (isnan(x)) return x;
    if (x > 709.782712893384) return INFINITY;
    if (x < -745.2) return 0;
    const real y = exponential_parts(x, &shifted);
    const int k = (int)(shifted - WHOLE); /* 2^k itself may be beyond what a number can hold */
    return y * power_of_two(k / 2) * power_of_two(k - k / 2);
}

void exponential_of_four(const real x[4], real y[4])
{
    int is_moderate = 1;
    for (int i = 0; i < 4; i++) is_moderate &= fabs(x[i]) < 700;
    if (is_moderate)
        for (int i = 0; i < 4; i++) y[i] = moderate_exponential(x[i]);
    else
        for (int i = 0; i < 4; i++) y[i] = exponential(x[i]);
}

real exponential_less_one(real x)
{
    if (!(fabs(x) <= 0.68)) return exponential(x) - 1; /* loses a digit at most; also NaN */
    const real r = fabs(x) > 0.34 ? 0.5 * x : x, z = r * r, c = r - z * POLYNOMIAL(z, EXP);
    const real m = r + r * c / (2 - c);
    return fabs(x) > 0.34 ? m * (m + 2) : m; /* (1 + m)^2 - 1 */
}

real logarithm(real x)
{
    int k = 0;
    if (!(x >= 2.2250738585072014e-308 && x <= 1.7976931348623157e308)) {
        if (!(x > 0)) return x == 0 ? -INFINITY : NAN;
        if (isinf(x)) return x;
        x *= 18014398509481984.0, k = -54; /* 2^54 */
    }
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    k += (int)(bits >> 52) - 1023;
    bits = (bits & 0xfffffffffffffu) | (uint64_t)1023 << 52;
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
