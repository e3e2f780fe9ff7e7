/* hill_degroote2016: curves in closed form, twice continuously differentiable.

   De Groote, Kinney, Rao & Fregly 2016, Ann. Biomed. Eng. 44: Evaluation of direct collocation optimal
   control problem formulations for solving the muscle redundancy problem. The coefficients are those of
   OpenSim's DeGrooteFregly2016Muscle, which have more digits than the paper, so that fL(1) = 1 and fV(0) =
   1. */
#include "../../math/elementary.h"
#include "hill.h"

#include <math.h>
#include <stddef.h>

enum {
    DEGROOTE_PER_WIDTH = HILL_CONSTANTS,
    DEGROOTE_PASSIVE_RATE,
    DEGROOTE_PASSIVE_FOOT,
    DEGROOTE_PASSIVE_SCALE,
    DEGROOTE_TENDON_RATE,
    DEGROOTE_CONSTANTS
};

/* Three Gauss curves of height BELL[0] about BELL[1] with width BELL[2] + BELL[3] z. */
enum { BELLS = 3 };
static const real BELL[BELLS][4] = {
    {0.8150671134243542, 1.055033428970575, 0.162384573599574, 0.063303448465465},
    {0.433004984392647, 0.716775413397760, -0.029947116970696, 0.200356847296188},
    {0.1, 1.0, 0.353553390593274, 0.0},
};

/* Return the length for the active curve, whose width is scaled. */
static inline real scaled(const real *k, real x)
{
    return (x - 1) * k[DEGROOTE_PER_WIDTH] + 1;
}

static inline real per_width(const real b[4], real z)
{
    return 1 / (b[2] + b[3] * z);
}

static inline real bell_exponent(const real b[4], real z)
{
    const real ratio = (z - b[1]) * per_width(b, z);
    return -0.5 * ratio * ratio;
}

static real degroote_active(const real *k, real x, real *slope)
{
    const real z = scaled(k, x);
    real sum = 0, rate = 0;
    for (int i = 0; i < BELLS; i++) {
        const real *b = BELL[i], ratio = (z - b[1]) * per_width(b, z);
        const real y = b[0] * exponential(bell_exponent(b, z));
        sum += y;
        if (value_of(y) > 0) rate += -y * ratio * (1 - ratio * b[3]) * per_width(b, z);
    }
    if (slope) *slope = rate * k[DEGROOTE_PER_WIDTH];
    return sum;
}

static real degroote_velocity(const real *k, real w, real *slope)
{
    static const real D1 = -0.3211346127989808, D2 = -8.149, D3 = -0.374, D4 = 0.8825327733249912;
    (void)k;
    const real s = D2 * w + D3, root = sqrt(s * s + 1);
    if (slope) *slope = D1 * D2 / root;
    return D1 * logarithm(s + root) + D4;
}

static real degroote_passive(const real *k, real x, real *slope)
{
    const real y = exponential(k[DEGROOTE_PASSIVE_RATE] * (x - 1));
    if (slope) *slope = k[DEGROOTE_PASSIVE_RATE] * y * k[DEGROOTE_PASSIVE_SCALE];
    return (y - k[DEGROOTE_PASSIVE_FOOT]) * k[DEGROOTE_PASSIVE_SCALE];
}

/* Compute four exponentials at once. */
static real degroote_product(const real *k, real x, real w, real *passive)
{
    const real z = scaled(k, x);
    real exponents[BELLS + 1], y[BELLS + 1];
    for (int i = 0; i < BELLS; i++) exponents[i] = bell_exponent(BELL[i], z);
    exponents[BELLS] = k[DEGROOTE_PASSIVE_RATE] * (x - 1);
    exponential_of_four(exponents, y);
    *passive = (y[BELLS] - k[DEGROOTE_PASSIVE_FOOT]) * k[DEGROOTE_PASSIVE_SCALE];
    return (BELL[0][0] * y[0] + BELL[1][0] * y[1] + BELL[2][0] * y[2]) * degroote_velocity(k, w, NULL);
}

static real degroote_tendon(const real *k, real x, real *slope)
{
    const real y = 0.2 * exponential(k[DEGROOTE_TENDON_RATE] * (x - 1));
    if (slope) *slope = k[DEGROOTE_TENDON_RATE] * y;
    return y - 0.2;
}

static const hill_curves degroote_curves = {degroote_active, degroote_velocity, degroote_passive,
                                            degroote_tendon, NULL,              degroote_product};
HILL_FUNCTIONS(degroote)

/* Compute the constants. The passive curve is 0 at the minimum fibre length and 1 at its strain. */
static void degroote_prepare(const void *parameters, real *k)
{
    const hill_degroote2016_parameters *p = parameters;
    const real shape = 4, shortest = 0.2, strain = p->passive_fibre_strain;
    hill_prepare(parameters, p->elastic_tendon ? shortest : 0, 1.5707963267948966, p->fibre_damping,
                 p->activation_smoothing, k);
    k[DEGROOTE_PER_WIDTH] = 1 / p->active_width_scale;
    k[DEGROOTE_PASSIVE_RATE] = shape / strain;
    k[DEGROOTE_PASSIVE_FOOT] = exponential(shape * (shortest - 1) / strain);
    k[DEGROOTE_PASSIVE_SCALE] = 1 / (exponential(shape) - k[DEGROOTE_PASSIVE_FOOT]);
    k[DEGROOTE_TENDON_RATE] = logarithm((1 + 0.2) / 0.2) / p->tendon_strain;
}

TENSION_LAW(hill_degroote2016) = {HILL_LAW(degroote, DEGROOTE_CONSTANTS)};
