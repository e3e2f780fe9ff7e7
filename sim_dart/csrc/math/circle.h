/* Sine and cosine. */
#ifndef CARDSFLOW_CIRCLE_H
#define CARDSFLOW_CIRCLE_H

#include "polynomial.h"

static const constant TURNS = 0.6366197723675814; /* 2/pi */

/* Compute x minus the nearest multiple of pi/2, as high + low; return the multiple modulo 4. */
static inline whole circle_reduce(real x, real *high, real *low)
{
    const real turns = x * TURNS, n = without_fraction(choose(turns < 0, turns - 0.5, turns + 0.5));
    real rest = x, lost = number(0);
    for (int k = 0; k < 4; k++) { /* Knuth's two-sum keeps the rounding error */
        const real part = -n * QUARTER[k], sum = rest + part, back = sum - rest;
        lost += (rest - (sum - back)) + (part - back);
        rest = sum;
    }
    *high = rest + lost;
    *low = (rest - *high) + lost;
    return whole_of(n) & 3;
}

/* Compute the sine of high + low, |high + low| <= pi/4. */
static inline real circle_small_sine(real high, real low)
{
    const real z = high * high;
    return high + (z * high * POLYNOMIAL(z, SINE) + low * (1 - 0.5 * z));
}

static inline real circle_small_cosine(real high, real low)
{
    const real z = high * high, half = 0.5 * z, w = 1 - half;
    return w + (((1 - w) - half) + (z * z * POLYNOMIAL(z, COSINE) - high * low));
}

/* The results are NaN if x is not finite. */
static inline void circle_at(real x, real *sine, real *cosine)
{
    const truth is_usual = fabs(x) <= MAX_ANGLE;
    if (!all_of(is_usual)) x = choose(is_usual, x, fmod(x, 6.283185307179586));
    const truth is_turned = fabs(x) > 0.785;
    real high = x, low = number(0);
    whole quarter = {0};
    if (any_of(is_turned)) {
        quarter = circle_reduce(x, &high, &low);
        high = choose(is_turned, high, x), low = choose(is_turned, low, number(0));
    }
    const real s = circle_small_sine(high, low), c = circle_small_cosine(high, low);
    const truth is_swapped = is_turned & ((quarter & 1) != 0), is_behind = is_turned & ((quarter & 2) != 0);
    const real along = choose(is_swapped, s, c), across = choose(is_swapped, c, s);
    *sine = choose(is_behind, -across, across);
    *cosine = choose(is_behind != is_swapped, -along, along);
}

#endif
