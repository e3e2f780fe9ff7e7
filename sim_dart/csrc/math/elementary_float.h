/* Coefficients of elementary.c for single precision: relative errors of the polynomials are below 4e-9. */
#ifndef CARDSFLOW_ELEMENTARY_FLOAT_H
#define CARDSFLOW_ELEMENTARY_FLOAT_H

#include "../numbers/real.h"

/* Bits of a number: number of mantissa bits, and bias of the exponent. */
typedef uint32_t real_bits;
enum { FRACTION_BITS = 23, EXPONENT_BIAS = 127 };
static const constant MIN_NORMAL = 1.17549435e-38, MAX_NUMBER = 3.40282347e38;

/* pi/2 in parts of 12 bits, so that multiples below 2^12 of all parts but the last are exact. */
static const constant QUARTER[4] = {1.57080078125, -4.453584551811218e-06, -8.706138032721356e-10,
                                6.223371969669989e-14};
static const constant MAX_ANGLE = 4096; /* beyond, the rounding error of 2 pi is below that of the angle */

/* (sin x - x)/x^3 and (cos x - 1 + x^2/2)/x^4 by x^2, for |x| <= pi/4 */
static const constant SINE[] = {-0.16666655, 0.008332192, -0.00019518791};
static const constant COSINE[] = {0.041666646, -0.0013887301, 2.443067e-05};

static const constant LN2_HIGH = 0.693145751953125, LN2_LOW = 1.428606765330187e-06; /* 16 bits + rest */

/* (r (e^r + 1)/(e^r - 1) - 2)/r^2 by r^2, for |r| <= ln(2)/2 */
static const constant EXP[] = {0.16666625, -0.0027667128};
static const constant MODERATE_EXPONENT = 87, MAX_EXPONENT = 88.72283, MIN_EXPONENT = -104;

/* (ln((1 + s)/(1 - s)) - 2s)/s^3 by s^2, for 1 + f within sqrt(1/2) and sqrt(2), s = f/(2 + f) */
static const constant LOG[] = {0.66666776, 0.39977583, 0.29870796};

/* (tanh x - x)/x^3 by x^2, for |x| <= 0.4 */
static const constant TANH[] = {-0.333333, 0.13331203, -0.05356018, 0.018736495};

/* The sum with a number below 2^22 contains the nearest integer in its last bits. */
static const constant WHOLE = 12582912.0; /* 2^23 + 2^22 */

/* Scales subnormal numbers to normal numbers. */
static const constant RAISE = 33554432.0; /* 2^25 */
enum { RAISED = 25 };

#endif
