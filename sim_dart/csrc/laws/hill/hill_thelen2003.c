/* hill_thelen2003: a Gauss curve, exponentials, and Hill's hyperbola, whose velocity scales with activation.

   Thelen 2003, J. Biomech. Eng. 125: Adjustment of muscle mechanics model parameters to simulate dynamic
   contractions in older adults. The toe of the tendon is exact: it joins the straight line with equal slope. */
#include "../../math/elementary.h"
#include "hill.h"

#include <math.h>
#include <stddef.h>

enum {
    THELEN_ACTIVE_SHAPE = HILL_CONSTANTS,
    THELEN_PASSIVE_RATE,
    THELEN_PASSIVE_SCALE,
    THELEN_CONCENTRIC_SHAPE,
    THELEN_ECCENTRIC_FORCE,
    THELEN_ECCENTRIC_SHAPE,
    THELEN_LINEAR_FROM, /* begin of the linear part: velocity */
    THELEN_TOE_STRAIN,
    THELEN_TOE_SCALE,
    THELEN_TENDON_SLOPE,
    THELEN_CONSTANTS
};

static const real TOE_FORCE = 0.33, TOE_SHAPE = 3;
/* Minimum fibre length, in optimal lengths: OpenSim bounds fibres by their pennation only. It is above 0
   since it is a divisor. */
static const real MIN_LENGTH = PRECISE(1e-12, 1e-6);

static real thelen_active(const real *k, real x, real *slope)
{
    const real y = exponential(-(x - 1) * (x - 1) / k[THELEN_ACTIVE_SHAPE]);
    if (slope) *slope = -2 * (x - 1) / k[THELEN_ACTIVE_SHAPE] * y;
    return y;
}

/* Evaluate Hill's hyperbola, to w = -1 where a fibre shortens without force, and its mirror image for
   lengthening. */
static real thelen_hyperbola(const real *k, real w, real *slope)
{
    const real most = value_of(w) < 0 ? 0 : k[THELEN_ECCENTRIC_FORCE];
    const real bend = value_of(w) < 0 ? -1 / k[THELEN_CONCENTRIC_SHAPE] : k[THELEN_ECCENTRIC_SHAPE];
    const real top = value_of(w) < 0 ? 1 + w : 1 + bend * most * w, under = 1 + bend * w;
    const real rise = value_of(w) < 0 ? 1 : bend * most;
    *slope = (rise * under - bend * top) / (under * under);
    return top / under;
}

/* Evaluate the force-velocity curve: beyond the end of the hyperbola, and near its upper asymptote, it is a
   straight line. */
static real thelen_velocity(const real *k, real w, real *slope)
{
    real inner_slope;
    const real inside = clamped(w, -1, k[THELEN_LINEAR_FROM]), y = thelen_hyperbola(k, inside, &inner_slope);
    if (slope) *slope = inner_slope;
    return y + inner_slope * (w - inside);
}

static real thelen_passive(const real *k, real x, real *slope)
{
    if (value_of(x) <= 1) {
        if (slope) *slope = 0;
        return 0;
    }
    const real rate = k[THELEN_PASSIVE_RATE], scale = k[THELEN_PASSIVE_SCALE];
    const real grown = exponential_less_one(rate * (x - 1));
    if (slope) *slope = rate * (1 + grown) / scale;
    return grown / scale;
}

static real thelen_tendon(const real *k, real x, real *slope)
{
    const real strain = x - 1;
    if (value_of(strain) > value_of(k[THELEN_TOE_STRAIN])) {
        if (slope) *slope = k[THELEN_TENDON_SLOPE];
        return k[THELEN_TENDON_SLOPE] * (strain - k[THELEN_TOE_STRAIN]) + TOE_FORCE;
    }
    const real rate = TOE_SHAPE / k[THELEN_TOE_STRAIN], on = value_of(strain) > 0 ? strain : 0;
    const real grown = exponential_less_one(rate * on);
    if (slope) *slope = value_of(strain) > 0 ? rate * (1 + grown) * k[THELEN_TOE_SCALE] : 0;
    return grown * k[THELEN_TOE_SCALE];
}

/* Return the factor of the maximum velocity: an inactive muscle shortens at a quarter of the speed. */
static real thelen_speed(real a)
{
    return 0.25 + 0.75 * a;
}

static void thelen_prepare(const void *parameters, real *k)
{
    const hill_thelen2003_parameters *p = parameters;
    hill_prepare(parameters, MIN_LENGTH, 1.4706289056333368, 0, 0, k);
    k[THELEN_ACTIVE_SHAPE] = p->active_shape, k[THELEN_CONCENTRIC_SHAPE] = p->concentric_shape;
    k[THELEN_PASSIVE_RATE] = p->passive_shape / p->passive_fibre_strain;
    k[THELEN_PASSIVE_SCALE] = exponential_less_one(p->passive_shape);
    const real most = p->eccentric_force, bent = p->linear_from * most;
    k[THELEN_ECCENTRIC_FORCE] = most;
    k[THELEN_ECCENTRIC_SHAPE] = (2 + 2 / p->concentric_shape) / (most - 1);
    k[THELEN_LINEAR_FROM] = (bent - 1) / (k[THELEN_ECCENTRIC_SHAPE] * (most - bent));
    /* The toe rises to TOE_FORCE with the slope of the straight line. Its strain e_t solves
          TOE_SHAPE TOE_FORCE exp(TOE_SHAPE) / (exp(TOE_SHAPE) - 1) / e_t = (1 - TOE_FORCE) / (strain - e_t) */
    const real grown = exponential(TOE_SHAPE), toe_slope = TOE_SHAPE * TOE_FORCE * grown / (grown - 1);
    k[THELEN_TOE_STRAIN] = p->tendon_strain * toe_slope / (1 - TOE_FORCE + toe_slope);
    k[THELEN_TOE_SCALE] = TOE_FORCE / (grown - 1);
    k[THELEN_TENDON_SLOPE] = (1 - TOE_FORCE) / (p->tendon_strain - k[THELEN_TOE_STRAIN]);
}

static const hill_curves thelen_curves = {thelen_active, thelen_velocity, thelen_passive,
                                          thelen_tendon, thelen_speed,    NULL};
HILL_FUNCTIONS(thelen)

TENSION_LAW(hill_thelen2003) = {HILL_LAW(thelen, THELEN_CONSTANTS)};
