/* Activation dynamics: a' = (u - a) / tau, with tau = rise (1/2 + 3/2 a) while a rises and tau = fall / (1/2
   + 3/2 a) while it falls. The transition between the two is a switch (Thelen 2003, Millard et al. 2013) or
   smooth (De Groote et al. 2016, eq. 1-2). */
#include "activation.h"

#include "../../math/elementary.h"

#include <math.h>

/* Maximum decay in a step of a method that is only conditionally stable. */
#define MAX_DECAY 0.14
#define MAX_ACTIVATION_STEPS 256

/* Approximation of tanh for |y| <= 0.11, with the relative error 2e-11, which is negligible in a step of
   order four. */
#define SMALL_TANH 0.11
static inline real small_tanh(real y)
{
    const real z = y * y;
    return y * ((1 - 0.3333333321329352 * z) + z * z * (0.13333154591577318 - 0.05357358173625689 * z));
}

static inline real quick_tanh(real y)
{
    return value_of(fabs(y)) > SMALL_TANH ? hyperbolic_tangent(y) : small_tanh(y);
}

/* Return the maximum 1 / tau between a and u: it decreases with a while rising, and increases while falling. */
static inline real max_rate_constant(const real *k, real a, real u)
{
    const int is_rising = value_of(u) > value_of(a);
    const real rise = k[HILL_RISE] / (0.5 + 1.5 * (is_rising ? a : u));
    const real fall = (0.5 + 1.5 * (is_rising ? u : a)) * k[HILL_FALL];
    if (k[HILL_SMOOTHING] == 0) return is_rising ? rise : fall;
    return larger(rise, fall);
}

/* Return 1 / tau. */
static inline real activation_rate_constant(const real *k, real a, real u)
{
    const real slowness = 0.5 + 1.5 * a;
    if (k[HILL_SMOOTHING] == 0)
        return value_of(u) > value_of(a) ? k[HILL_RISE] / slowness : slowness * k[HILL_FALL];
    const real rising = 0.5 + 0.5 * quick_tanh(k[HILL_SMOOTHING] * (u - a)), fall = slowness * k[HILL_FALL];
    return fall + rising * (k[HILL_RISE] / slowness - fall);
}

real activation_rate(const real *k, real a, real u)
{
    return (u - a) * activation_rate_constant(k, a, u);
}

#define SMOOTHING (real)0.1 /* De Groote et al. 2016: instead of a switch */
#define MAX_SMOOTHING 2     /* up to which a' increases with u for all time constants */
#define INVERSE_STEPS 20

void activation_inverse(const real *k, real a, real rate, real value[3])
{
    const real slowness = 0.5 + 1.5 * a, smoothing = k[HILL_SMOOTHING];
    const real rise = k[HILL_RISE] / slowness, fall = slowness * k[HILL_FALL];
    const real sharp = smoothing == 0 || value_of(smoothing) > MAX_SMOOTHING ? SMOOTHING : smoothing;
    real away = 2 * rate / (rise + fall), slope = 1, rising = 0.5;
    for (int i = 0; i < INVERSE_STEPS; i++) {
        const real t = hyperbolic_tangent(sharp * away);
        rising = 0.5 + 0.5 * t;
        slope = fall + (rising + away * sharp * (1 - t * t) / 2) * (rise - fall);
        const real step = (away * (fall + rising * (rise - fall)) - rate) / slope;
        away -= step;
        if (value_of(fabs(step)) <= PRECISE(1e-13, 1e-6)) break;
    }
    const real by_activation = 1.5 * (k[HILL_FALL] - rising * (k[HILL_FALL] + rise / slowness));
    value[0] = a + away;
    value[1] = 1 - away * by_activation / slope;
    value[2] = 1 / slope;
}

/* Advance by the classical fourth-order Runge-Kutta method. */
static inline real accurate_step(const real *k, real a, real u, real h)
{
    const real one = (u - a) * activation_rate_constant(k, a, u);
    real b = a + h / 2 * one;
    const real two = (u - b) * activation_rate_constant(k, b, u);
    b = a + h / 2 * two;
    const real three = (u - b) * activation_rate_constant(k, b, u);
    b = a + h * three;
    const real four = (u - b) * activation_rate_constant(k, b, u);
    return a + h / 6 * (one + 2 * two + 2 * three + four);
}

/* Advance by the exponential midpoint rule, for steps that are long compared to tau: a never passes u. */
static real stable_step(const real *k, real a, real u, real h)
{
    const real middle = u + (a - u) / (1 + activation_rate_constant(k, a, u) * h / 2);
    return u + (a - u) * exponential(-h * activation_rate_constant(k, middle, u));
}

real activation_after(const real *k, real a, real u, real h)
{
    a = hill_activation(k, a);
    if (value_of(2 * h * larger(k[HILL_RISE], k[HILL_FALL])) <= MAX_DECAY) /* no 1 / tau is larger */
        return hill_activation(k, accurate_step(k, a, u, h));
    const real decay = h * max_rate_constant(k, a, u);
    if (value_of(decay) <= MAX_DECAY) return hill_activation(k, accurate_step(k, a, u, h));
    const int steps = whole_steps(ceil(decay / MAX_DECAY), MAX_ACTIVATION_STEPS);
    const real part = h / steps;
    if (value_of(decay) <= MAX_DECAY * steps)
        for (int i = 0; i < steps; i++) a = accurate_step(k, a, u, part);
    else
        for (int i = 0; i < steps; i++) a = stable_step(k, a, u, part);
    return hill_activation(k, a);
}

/* ------------------------------------------------------------------------------------ several muscles at
   once */

/* Compute activation_rate_constant times (u - a); 0 means no smoothing. */
static void find_rates(const activations *s, const real *at, real *restrict rate)
{
    for (int i = 0; i < s->count; i++) {
        const real away = s->u[i] - at[i], rising = 0.5 + 0.5 * small_tanh(s->smoothing[i] * away);
        const real slowness = 0.5 + 1.5 * at[i], fall = slowness * s->fall[i];
        rate[i] = away * (fall + rising * (s->rise[i] / slowness - fall));
    }
}

static void step_to(const activations *s, real part, const real *rate, real *restrict to)
{
    for (int i = 0; i < s->count; i++) to[i] = s->a[i] + part * s->step[i] * rate[i];
}

/* Compute quickest times h. */
static void find_decays(activations *s, real h)
{
    for (int i = 0; i < s->count; i++) {
        const real low = smaller(s->a[i], s->u[i]), high = larger(s->a[i], s->u[i]);
        s->decay[i] = h * larger(s->rise[i] / (0.5 + 1.5 * low), (0.5 + 1.5 * high) * s->fall[i]);
    }
}

/* Advance all by accurate_step. */
static void step_all(activations *s)
{
    real at[ACTIVATIONS] = {0}, one[ACTIVATIONS], two[ACTIVATIONS], three[ACTIVATIONS], four[ACTIVATIONS];
    find_rates(s, s->a, one);
    step_to(s, 0.5, one, at);
    find_rates(s, at, two);
    step_to(s, 0.5, two, at);
    find_rates(s, at, three);
    step_to(s, 1, three, at);
    find_rates(s, at, four);
    for (int i = 0; i < s->count; i++)
        s->a[i] += s->step[i] / 6 * (one[i] + 2 * two[i] + 2 * three[i] + four[i]);
}

/* Advance by one step or two half steps; if a step is still too long, advance the muscle separately. */
void activations_finish(activations *s, real h)
{
    int is_any_halved = 0;
    find_decays(s, h);
    for (int i = 0; i < s->count; i++) {
        const int is_halved = value_of(s->decay[i]) > MAX_DECAY;
        is_any_halved |= is_halved;
        s->step[i] = is_halved ? h / 2 : h;
    }
    step_all(s);
    for (int i = 0; i < s->count; i++) s->step[i] = h - s->step[i];
    if (is_any_halved) step_all(s);
    for (int i = 0; i < s->count; i++) {
        const real *k = s->k[i], a = *s->state[i];
        const int is_slow = value_of(s->decay[i]) <= 2 * MAX_DECAY;
        *s->state[i] = is_slow ? hill_activation(k, s->a[i]) : activation_after(k, a, s->u[i], h);
    }
    s->count = 0;
}

void activations_add(activations *s, const real *k, real *a, real u, real h)
{
    const real smoothing = k[HILL_SMOOTHING];
    if (smoothing == 0 || value_of(smoothing) > SMALL_TANH) { /* a switch is fast enough separately */
        *a = activation_after(k, *a, u, h);
        return;
    }
    const int i = s->count++;
    s->k[i] = k, s->state[i] = a;
    s->a[i] = hill_activation(k, *a), s->u[i] = u;
    s->rise[i] = k[HILL_RISE], s->fall[i] = k[HILL_FALL], s->smoothing[i] = smoothing;
    if (s->count == ACTIVATIONS) activations_finish(s, h);
}
