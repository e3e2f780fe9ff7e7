/* hill_degroote2016: curves in closed form, twice continuously differentiable.

   De Groote, Kinney, Rao & Fregly 2016, Ann. Biomed. Eng. 44: Evaluation of direct collocation optimal
   control problem formulations for solving the muscle redundancy problem. The numbers are those of
   OpenSim's DeGrooteFregly2016Muscle: more digits than printed, so that fL(1) = 1 and fV(0) = 1.      */
#include "hill.h"

#include <math.h>
#include <stddef.h>

enum { DE_GROOTE_PARAMETERS(AT) PARAMETERS };
enum { PER_WIDTH = HILL_CONSTANTS, PASSIVE_RATE, PASSIVE_FOOT, PASSIVE_SCALE, TENDON_RATE, CONSTANTS };

/* A Gauss curve of height b[0] about b[1], as wide as b[2] + b[3] z. */
static inline double skewed(const double b[4], double z, double *slope)
{
    const double per_width = 1 / (b[2] + b[3] * z), ratio = (z - b[1]) * per_width;
    const double y = b[0] * exp(-0.5 * ratio * ratio);
    if (slope && y > 0) *slope += -y * ratio * (1 - ratio * b[3]) * per_width;
    return y;
}

static double active(const double *k, double x, double *slope)
{
    static const double LONG[] = {0.8150671134243542, 1.055033428970575, 0.162384573599574,
                                  0.063303448465465};
    static const double SHORT[] = {0.433004984392647, 0.716775413397760, -0.029947116970696,
                                   0.200356847296188};
    static const double MIDDLE[] = {0.1, 1.0, 0.353553390593274, 0.0};
    const double z = (x - 1) * k[PER_WIDTH] + 1;
    if (slope) *slope = 0;
    const double y = skewed(LONG, z, slope) + skewed(SHORT, z, slope) + skewed(MIDDLE, z, slope);
    if (slope) *slope *= k[PER_WIDTH];
    return y;
}

static double velocity(const double *k, double w, double *slope)
{
    static const double D1 = -0.3211346127989808, D2 = -8.149, D3 = -0.374, D4 = 0.8825327733249912;
    (void)k;
    const double s = D2 * w + D3, root = sqrt(s * s + 1);
    if (slope) *slope = D1 * D2 / root;
    return D1 * log(s + root) + D4;
}

static double passive(const double *k, double x, double *slope)
{
    const double y = exp(k[PASSIVE_RATE] * (x - 1));
    if (slope) *slope = k[PASSIVE_RATE] * y * k[PASSIVE_SCALE];
    return (y - k[PASSIVE_FOOT]) * k[PASSIVE_SCALE];
}

static double tendon(const double *k, double x, double *slope)
{
    const double y = 0.2 * exp(k[TENDON_RATE] * (x - 1));
    if (slope) *slope = k[TENDON_RATE] * y;
    return y - 0.2;
}

static const hill_curves CURVES = {active, velocity, passive, tendon, NULL};
HILL_FUNCTIONS(CURVES)

static const char *refusal(const double *p)
{
    if (p[AT_fibre_damping] < 0) return "fibre_damping must not be negative";
    if (!(p[AT_active_width_scale] > 0)) return "active_width_scale must be positive";
    if (!(p[AT_passive_fibre_strain] > 0)) return "passive_fibre_strain must be positive";
    if (!(p[AT_tendon_strain] > 0)) return "tendon_strain must be positive";
    if (!(p[AT_activation_smoothing] > 0)) return "activation_smoothing must be positive";
    return hill_refusal(p);
}

/* The passive curve is 0 at the shortest fibre and 1 at its strain. */
static void prepare(const double *p, double *k)
{
    const double shape = 4, shortest = 0.2, strain = p[AT_passive_fibre_strain];
    hill_prepare(p, p[AT_elastic_tendon] ? shortest : 0, 1.5707963267948966, p[AT_fibre_damping],
                 p[AT_activation_smoothing], k);
    k[PER_WIDTH] = 1 / p[AT_active_width_scale];
    k[PASSIVE_RATE] = shape / strain, k[PASSIVE_FOOT] = exp(shape * (shortest - 1) / strain);
    k[PASSIVE_SCALE] = 1 / (exp(shape) - k[PASSIVE_FOOT]);
    k[TENDON_RATE] = log((1 + 0.2) / 0.2) / p[AT_tendon_strain];
}

const tension_law LAW_DE_GROOTE = HILL_LAW(PARAMETERS, CONSTANTS);
