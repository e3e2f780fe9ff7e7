/* mujoco_muscle: the muscle of MuJoCo, a Hill-type muscle with a rigid tendon.

   With the optimum L0 = (l1 - l0) / (r1 - r0), L = r0 + (l - l0) / L0 and V = l' / (L0 vmax), where the path
   length range l0 to l1 corresponds to the range r0 to r1 of L,

     f = F (FL(L) FV(V) a + FP(L)),   a' = (u - a) / tau

   Documentation of MuJoCo, "Muscles" in the chapter on modeling; Millard et al. 2013 for the activation. */
#include "../math/elementary.h"
#include "hill/activation.h"
#include "law.h"

enum {
    MUJOCO_RISE = HILL_CONSTANTS, /* time constants */
    MUJOCO_FALL,
    MUJOCO_WIDTH, /* transition width between them */
    MUJOCO_FORCE,
    MUJOCO_FROM, /* l0, r0, L0 */
    MUJOCO_MIN_LENGTH,
    MUJOCO_OPTIMUM,
    MUJOCO_PASSIVE_MIN_LENGTH,
    MUJOCO_PASSIVE_OPTIMUM,
    MUJOCO_SPEED, /* L0 vmax */
    MUJOCO_LMIN,
    MUJOCO_LMAX,
    MUJOCO_PASSIVE_LMAX,
    MUJOCO_FVMAX,
    MUJOCO_FPMAX,
    MUJOCO_CONSTANTS
};

static const real MUJOCO_MIN_DIVISOR = PRECISE(1e-15, 1e-15); /* minimum divisor */
#define MAX_MUJOCO_DECAY 0.14
#define MAX_MUJOCO_STEPS 256

static void mujoco_prepare(const void *parameters, real *k)
{
    const mujoco_muscle_parameters *p = parameters;
    const int is_same = p->passive_range_low == 0 && p->passive_range_high == 0;
    const real low = is_same ? p->range_low : p->passive_range_low;
    const real high = is_same ? p->range_high : p->passive_range_high, span = p->length_high - p->length_low;
    k[HILL_RISE] = 1 / p->activation_time_constant, k[HILL_FALL] = 1 / p->deactivation_time_constant;
    k[HILL_MIN_ACTIVATION] = k[HILL_SMOOTHING] = 0;
    k[MUJOCO_RISE] = p->activation_time_constant, k[MUJOCO_FALL] = p->deactivation_time_constant;
    k[MUJOCO_WIDTH] = p->activation_width;
    k[MUJOCO_FORCE] = value_of(p->force) < 0 ? p->scale / p->acc0 : p->force;
    k[MUJOCO_FROM] = p->length_low, k[MUJOCO_MIN_LENGTH] = p->range_low;
    k[MUJOCO_OPTIMUM] = span / (p->range_high - p->range_low);
    k[MUJOCO_PASSIVE_MIN_LENGTH] = low, k[MUJOCO_PASSIVE_OPTIMUM] = span / (high - low);
    k[MUJOCO_SPEED] = k[MUJOCO_OPTIMUM] * p->vmax;
    k[MUJOCO_LMIN] = p->lmin, k[MUJOCO_LMAX] = p->lmax;
    k[MUJOCO_PASSIVE_LMAX] = p->passive_lmax == 0 ? p->lmax : p->passive_lmax;
    k[MUJOCO_FVMAX] = p->fvmax, k[MUJOCO_FPMAX] = p->fpmax;
}

/* Return half the square of the relative position of x between a and b. */
static real half_square(real x, real a, real b)
{
    const real part = (x - a) / larger(b - a, MUJOCO_MIN_DIVISOR);
    return 0.5 * part * part;
}

static real mujoco_active(const real *k, real L)
{
    const real low = k[MUJOCO_LMIN], high = k[MUJOCO_LMAX], a = 0.5 * (low + 1), b = 0.5 * (1 + high);
    if (!(value_of(L) >= value_of(low) && value_of(L) <= value_of(high))) return 0;
    if (value_of(L) <= value_of(a)) return half_square(L, low, a);
    if (value_of(L) <= 1) return 1 - half_square(1 - L, 0, 1 - a);
    return value_of(L) <= value_of(b) ? 1 - half_square(L, 1, b) : half_square(high - L, 0, high - b);
}

static real mujoco_velocity(const real *k, real V)
{
    const real most = k[MUJOCO_FVMAX], y = most - 1;
    if (value_of(V) <= -1) return 0;
    if (value_of(V) <= 0) return (V + 1) * (V + 1);
    return value_of(V) <= value_of(y) ? most - (y - V) * (y - V) / larger(y, MUJOCO_MIN_DIVISOR) : most;
}

static real mujoco_passive(const real *k, real L)
{
    const real b = 0.5 * (1 + k[MUJOCO_PASSIVE_LMAX]), width = larger(b - 1, MUJOCO_MIN_DIVISOR);
    if (value_of(L) <= 1) return 0;
    if (value_of(L) <= value_of(b)) return k[MUJOCO_FPMAX] * half_square(L, 1, b);
    return k[MUJOCO_FPMAX] * (0.5 + (L - b) / width);
}

static real mujoco_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)u;
    const real along = l - k[MUJOCO_FROM], L = k[MUJOCO_MIN_LENGTH] + along / k[MUJOCO_OPTIMUM];
    const real passive = k[MUJOCO_PASSIVE_MIN_LENGTH] + along / k[MUJOCO_PASSIVE_OPTIMUM];
    const real active = mujoco_active(k, L) * mujoco_velocity(k, v / k[MUJOCO_SPEED]);
    return k[MUJOCO_FORCE] * active * x[0] + k[MUJOCO_FORCE] * mujoco_passive(k, passive);
}

/* Return the activation rate. Over the width it changes as a polynomial of degree five, centred at u = a. */
static real mujoco_rate(const real *k, real a, real u)
{
    const real within = clamped(a, 0, 1), slowness = 0.5 + 1.5 * within, away = u - a;
    const real rise = k[MUJOCO_RISE] * slowness, fall = k[MUJOCO_FALL] / slowness;
    real tau = value_of(away) > 0 ? rise : fall;
    if (value_of(k[MUJOCO_WIDTH]) >= value_of(MUJOCO_MIN_DIVISOR)) {
        const real s = clamped(away / k[MUJOCO_WIDTH] + 0.5, 0, 1);
        tau = fall + (rise - fall) * (s * s * s * (3 * s * (2 * s - 5) + 10));
    }
    return away / larger(tau, MUJOCO_MIN_DIVISOR);
}

static void mujoco_rates(const real *k, const real *x, real l, real v, real u, real *xd)
{
    (void)l, (void)v;
    xd[0] = mujoco_rate(k, x[0], u);
}

static void mujoco_start(const real *k, real l, real u, real *x)
{
    (void)k, (void)l;
    x[0] = u;
}

/* Advance by the classical fourth-order method; a switch is handled as for other muscles. */
static void mujoco_advance(const real *k, real *x, real l, real v, real u, real h)
{
    (void)l, (void)v;
    if (!(value_of(k[MUJOCO_WIDTH]) >= value_of(MUJOCO_MIN_DIVISOR))) {
        x[0] = activation_after(k, x[0], u, h);
        return;
    }
    const real decay = h * larger(2 * k[HILL_RISE], 2 * k[HILL_FALL]);
    const int steps = whole_steps(decay / MAX_MUJOCO_DECAY + 1, MAX_MUJOCO_STEPS);
    if (value_of(decay) > MAX_MUJOCO_DECAY * MAX_MUJOCO_STEPS) {
        x[0] = u;
        return;
    }
    const real part = h / steps;
    for (int i = 0; i < steps; i++) {
        const real one = mujoco_rate(k, x[0], u), two = mujoco_rate(k, x[0] + part / 2 * one, u);
        const real three = mujoco_rate(k, x[0] + part / 2 * two, u), four = mujoco_rate(k, x[0] + part * three, u);
        x[0] += part / 6 * (one + 2 * two + 2 * three + four);
    }
}

TENSION_LAW(mujoco_muscle) = {
    .constants = MUJOCO_CONSTANTS,
    .prepare = mujoco_prepare,
    .tension = mujoco_tension,
    .rates = mujoco_rates,
    .start = mujoco_start,
    .advance = mujoco_advance,
};
