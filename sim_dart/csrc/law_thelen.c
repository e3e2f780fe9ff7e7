/* hill_thelen2003: a bell, exponentials, and Hill's hyperbola, whose velocity scales with activation.

   Thelen 2003, J. Biomech. Eng. 125: Adjustment of muscle mechanics model parameters to simulate dynamic
   contractions in older adults. The tendon's toe is exact: it joins the line with equal slope.        */
#include "elementary.h"
#include "hill.h"

#include <math.h>
#include <stddef.h>

enum { THELEN_PARAMETERS(AT) PARAMETERS };
enum {
    ACTIVE_SHAPE = HILL_CONSTANTS,
    PASSIVE_SHAPE,
    PASSIVE_STRAIN,
    CONCENTRIC_SHAPE,
    ECCENTRIC_FORCE,
    ECCENTRIC_SHAPE,
    LINEAR_FROM, /* velocity */
    TOE_STRAIN,
    TOE_SCALE,
    TENDON_SLOPE,
    CONSTANTS
};

static const real TOE_FORCE = 0.33, TOE_SHAPE = 3;

static real active(const real *k, real x, real *slope)
{
    const real y = exponential(-(x - 1) * (x - 1) / k[ACTIVE_SHAPE]);
    if (slope) *slope = -2 * (x - 1) / k[ACTIVE_SHAPE] * y;
    return y;
}

/* Hill's hyperbola, to w = -1 where a fibre shortens without force, and its mirror for lengthening. */
static real hyperbola(const real *k, real w, real *slope)
{
    const real most = value_of(w) < 0 ? 0 : k[ECCENTRIC_FORCE];
    const real bend = value_of(w) < 0 ? -1 / k[CONCENTRIC_SHAPE] : k[ECCENTRIC_SHAPE];
    const real top = value_of(w) < 0 ? 1 + w : 1 + bend * most * w, under = 1 + bend * w;
    const real rise = value_of(w) < 0 ? 1 : bend * most;
    *slope = (rise * under - bend * top) / (under * under);
    return top / under;
}

/* Beyond where the hyperbola ends, and near to its upper asymptote, it goes on as a line. */
static real velocity(const real *k, real w, real *slope)
{
    real own;
    const real inside = clamped(w, -1, k[LINEAR_FROM]), y = hyperbola(k, inside, &own);
    if (slope) *slope = own;
    return y + own * (w - inside);
}

static real passive(const real *k, real x, real *slope)
{
    if (value_of(x) <= 1) {
        if (slope) *slope = 0;
        return 0;
    }
    const real rate = k[PASSIVE_SHAPE] / k[PASSIVE_STRAIN], scale = exponential_less_one(k[PASSIVE_SHAPE]);
    if (slope) *slope = rate * exponential(rate * (x - 1)) / scale;
    return exponential_less_one(rate * (x - 1)) / scale;
}

static real tendon(const real *k, real x, real *slope)
{
    const real strain = x - 1, rate = TOE_SHAPE / k[TOE_STRAIN];
    if (value_of(strain) > value_of(k[TOE_STRAIN])) {
        if (slope) *slope = k[TENDON_SLOPE];
        return k[TENDON_SLOPE] * (strain - k[TOE_STRAIN]) + TOE_FORCE;
    }
    const real on = value_of(strain) > 0 ? strain : 0;
    if (slope) *slope = value_of(strain) > 0 ? rate * exponential(rate * on) * k[TOE_SCALE] : 0;
    return exponential_less_one(rate * on) * k[TOE_SCALE];
}

/* A muscle that is not active shortens at a quarter of the speed. */
static real speed(real a)
{
    return 0.25 + 0.75 * a;
}

static const char *refusal(const real *p)
{
    if (!(value_of(p[AT_tendon_strain]) > 0)) return "tendon_strain must be positive";
    if (!(value_of(p[AT_passive_fibre_strain]) > 0)) return "passive_fibre_strain must be positive";
    if (!(value_of(p[AT_active_shape]) > 0)) return "active_shape must be positive";
    if (!(value_of(p[AT_passive_shape]) > 0 && value_of(p[AT_passive_shape]) <= 100))
        return "passive_shape must be positive, and 100 at most";
    if (!(value_of(p[AT_concentric_shape]) > 0)) return "concentric_shape must be positive";
    if (!(value_of(p[AT_eccentric_force]) > 1)) return "eccentric_force must be above 1";
    if (!(value_of(p[AT_linear_from]) > value_of(1 / p[AT_eccentric_force]) &&
          value_of(p[AT_linear_from]) < 1))
        return "linear_from must be below 1 and, times eccentric_force, above 1";
    return hill_refusal(p);
}

static void prepare(const real *p, real *k)
{
    hill_prepare(p, 0.01, 1.4706289056333368, 0, 0, k);
    k[ACTIVE_SHAPE] = p[AT_active_shape], k[PASSIVE_SHAPE] = p[AT_passive_shape];
    k[PASSIVE_STRAIN] = p[AT_passive_fibre_strain], k[CONCENTRIC_SHAPE] = p[AT_concentric_shape];
    const real most = p[AT_eccentric_force], bent = p[AT_linear_from] * most;
    k[ECCENTRIC_FORCE] = most;
    k[ECCENTRIC_SHAPE] = (2 + 2 / p[AT_concentric_shape]) / (most - 1);
    k[LINEAR_FROM] = (bent - 1) / (k[ECCENTRIC_SHAPE] * (most - bent));
    /* The toe rises to TOE_FORCE with the line's slope: its strain e_t is that where
       TOE_SHAPE TOE_FORCE exp(TOE_SHAPE) / (exp(TOE_SHAPE) - 1) / e_t = (1 - TOE_FORCE) / (strain - e_t) */
    const real grown = exponential(TOE_SHAPE), toe_slope = TOE_SHAPE * TOE_FORCE * grown / (grown - 1);
    k[TOE_STRAIN] = p[AT_tendon_strain] * toe_slope / (1 - TOE_FORCE + toe_slope);
    k[TOE_SCALE] = TOE_FORCE / (grown - 1);
    k[TENDON_SLOPE] = (1 - TOE_FORCE) / (p[AT_tendon_strain] - k[TOE_STRAIN]);
}

static const hill_curves CURVES = {active, velocity, passive, tendon, speed, NULL};
HILL_FUNCTIONS(CURVES)

const tension_law LAW_THELEN = HILL_LAW(PARAMETERS, CONSTANTS, 0);
