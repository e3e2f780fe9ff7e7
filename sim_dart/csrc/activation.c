/* Activation follows excitation: a' = (u - a) / tau, tau = rise (1/2 + 3/2 a) while it rises and
   fall / (1/2 + 3/2 a) while it falls. The change between the two is a switch (Thelen 2003, Millard et al.
   2013), or smooth (De Groote et al. 2016, eq. 1-2).                                                  */
#include "elementary.h"
#include "hill.h"

#include <math.h>

/* In a step of a rule that is not stable for any. */
#define LARGEST_DECAY 0.14
#define MOST_STEPS 256

/* tanh, quickly for small arguments: to 2e-11 of it, which no step of order four tells from the whole. */
static inline real quick_tanh(real y)
{
    const real z = y * y;
    if (value_of(z) > 0.0121) return hyperbolic_tangent(y);
    return y * ((1 - 0.3333333321329352 * z) + z * z * (0.13333154591577318 - 0.05357358173625689 * z));
}

/* The largest 1 / tau between a and u: it falls with a while rising, and grows while falling. */
static inline real quickest(const real *k, real a, real u)
{
    const int is_rising = value_of(u) > value_of(a);
    const real rise = k[HILL_RISE] / (0.5 + 1.5 * (is_rising ? a : u));
    const real fall = (0.5 + 1.5 * (is_rising ? u : a)) * k[HILL_FALL];
    if (k[HILL_SMOOTHING] == 0) return is_rising ? rise : fall;
    return larger(rise, fall);
}

/* 1 / tau */
static inline real quickness(const real *k, real a, real u)
{
    const real slowness = 0.5 + 1.5 * a;
    if (k[HILL_SMOOTHING] == 0)
        return value_of(u) > value_of(a) ? k[HILL_RISE] / slowness : slowness * k[HILL_FALL];
    const real rising = 0.5 + 0.5 * quick_tanh(k[HILL_SMOOTHING] * (u - a)), fall = slowness * k[HILL_FALL];
    return fall + rising * (k[HILL_RISE] / slowness - fall);
}

real activation_rate(const real *k, real a, real u)
{
    a = hill_activation(k, a);
    return (u - a) * quickness(k, a, u);
}

/* The classical Runge-Kutta rule of order 4. */
static inline real accurate_step(const real *k, real a, real u, real h)
{
    const real one = (u - a) * quickness(k, a, u);
    real b = a + h / 2 * one;
    const real two = (u - b) * quickness(k, b, u);
    b = a + h / 2 * two;
    const real three = (u - b) * quickness(k, b, u);
    b = a + h * three;
    const real four = (u - b) * quickness(k, b, u);
    return a + h / 6 * (one + 2 * two + 2 * three + four);
}

/* The exponential midpoint rule, for steps that are long against tau: a never passes u. */
static real stable_step(const real *k, real a, real u, real h)
{
    const real middle = u + (a - u) / (1 + quickness(k, a, u) * h / 2);
    return u + (a - u) * exponential(-h * quickness(k, middle, u));
}

real activation_after(const real *k, real a, real u, real h)
{
    a = hill_activation(k, a);
    if (value_of(2 * h * larger(k[HILL_RISE], k[HILL_FALL])) <= LARGEST_DECAY) /* no 1 / tau is larger */
        return hill_activation(k, accurate_step(k, a, u, h));
    const real decay = h * quickest(k, a, u);
    if (value_of(decay) <= LARGEST_DECAY) return hill_activation(k, accurate_step(k, a, u, h));
    const int steps = (int)clamped(ceil(decay / LARGEST_DECAY), 1, MOST_STEPS);
    const real part = h / steps;
    if (value_of(decay) <= LARGEST_DECAY * steps)
        for (int i = 0; i < steps; i++) a = accurate_step(k, a, u, part);
    else
        for (int i = 0; i < steps; i++) a = stable_step(k, a, u, part);
    return hill_activation(k, a);
}
