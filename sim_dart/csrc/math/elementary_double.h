/* Coefficients of elementary.c for double precision: relative errors of the polynomials are below 5e-18. */
#ifndef CARDSFLOW_ELEMENTARY_DOUBLE_H
#define CARDSFLOW_ELEMENTARY_DOUBLE_H

#include "../numbers/real.h"

/* Bits of a number: number of mantissa bits, and bias of the exponent. */
typedef uint64_t real_bits;
enum { FRACTION_BITS = 52, EXPONENT_BIAS = 1023 };
static const constant MIN_NORMAL = 2.2250738585072014e-308, MAX_NUMBER = 1.7976931348623157e308;

/* pi/2 in parts of 22 bits, so that multiples below 2^31 of all parts but the last are exact. */
static const constant QUARTER[4] = {1.570796012878418, 3.139164164167596e-07, 6.223371969669989e-14,
                                2.0222662487959506e-21};
static const constant MAX_ANGLE = 1e9; /* larger than any angle of a robot */

/* (sin x - x)/x^3 and (cos x - 1 + x^2/2)/x^4 by x^2, for |x| <= pi/4 */
static const constant SINE[] = {-0.16666666666666632,    0.008333333333322372,    -0.0001984126982977151,
                            2.7557313678691495e-06, -2.5050755954726174e-08, 1.5896665643172655e-10};
static const constant COSINE[] = {0.0416666666666666,     -0.0013888888888874066, 2.4801587289444864e-05,
                              -2.75573143410594e-07, 2.0875721678381953e-09, -1.1359562171885525e-11};

static const constant LN2_HIGH = 0.6931471803691238, LN2_LOW = 1.9082149292705877e-10; /* 32 bits + rest */

/* (r (e^r + 1)/(e^r - 1) - 2)/r^2 by r^2, for |r| <= ln(2)/2 */
static const constant EXP[] = {0.166666666666666, -0.002777777777698507, 6.613756312760736e-05,
                           -1.6533892597968386e-06, 4.137774110612632e-08};
static const constant MODERATE_EXPONENT = 700, MAX_EXPONENT = 709.782712893384, MIN_EXPONENT = -745.2;

/* (ln((1 + s)/(1 - s)) - 2s)/s^3 by s^2, for 1 + f within sqrt(1/2) and sqrt(2), s = f/(2 + f) */
static const constant LOG[] = {0.666666666666674,  0.39999999999378016, 0.2857142875130177, 0.22222197586901452,
                           0.1818361903429931, 0.15312568241503632, 0.14811560129883308};

/* (tanh x - x)/x^3 by x^2, for |x| <= 0.4 */
static const constant TANH[] = {-0.3333333333333333,    0.13333333333332628,   -0.0539682539675065,
                            0.02186948849693757,    -0.008863234346172966, 0.00359210589232848,
                            -0.0014555686280255324, 0.000587971111313554,  -0.00022913508403632726,
                            6.856938213882136e-05};

/* The sum with a number below 2^51 contains the nearest integer in its last bits. */
static const constant WHOLE = 6755399441055744.0; /* 2^52 + 2^51 */

/* Scales subnormal numbers to normal numbers. */
static const constant RAISE = 18014398509481984.0; /* 2^54 */
enum { RAISED = 54 };

#endif
