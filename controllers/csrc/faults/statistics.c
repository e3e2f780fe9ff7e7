/* Statistics of a channel and their thresholds.

   Mean of a window: with S = sum of weight times residual, I = sum of weights, and a constant model error of
   variance e^2, z = S / sqrt(I + e^2 I^2) is normal. The probability that one of K tests exceeds z is at most
   K P(|z|), so that P(|z|) = a / (2 K) bounds the expected number of false alarms per hour by a / 2.

   Repeated values: a sensor whose noise exceeds its resolution rarely repeats a value. If k of N values were repeated, the
   next one is repeated with probability (k + 1) / (N + 2) (uniform prior). A run of repeated values whose probability is
   less than a / 2 divided by the number of tests is an alarm. This is valid only if the noise exceeds the resolution:
   second differences of the values must be larger than the smallest change and comparable to the noise of the settings,
   in the block of values in which they are smallest, since fast motion enlarges them: a sensor without noise is constant
   when its joint rests, for example at a limit. */
#include "state.h"

enum { LAGS = 12, BLOCK = 48, MAX_SEEN = 1 << 20 };
static const int LAG[LAGS] = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64};

static const real HOUR = 3600;
/* Second differences of noise, in multiples of the smallest change; chosen far above those of rounding errors, 0.7. With
   this white noise, a value is repeated with the probability sqrt(6) / (2 sqrt(pi) MIN_STEPS) at most. */
static const real MIN_STEPS = 8, MAX_REPEATS = (real)(0.691 / 8);
/* In multiples of the noise of the settings, chosen: changes that are only rounding errors of a subtraction; the least noise of
   a sensor whose settings are not too large by more than a factor of four. */
static const real ROUNDING = (real)1e-4, MIN_NOISE = (real)0.25;

/* Return z^2 / 2 with 2 phi(z) / z = tail, an upper bound of the quantile of a normal number. */
static real half_square(real log_tail)
{
    const real constant = logarithm(2 / sqrt(2 * (real)PI)) - log_tail;
    real half = larger(constant, (real)0.5);
    for (int k = 0; k < 20; k++) half = larger(constant - logarithm(2 * half) / 2, (real)0.125);
    return half;
}

void faults_set_limits(faults *s, real h)
{
    const real log_ticks = logarithm(HOUR / h) + logarithm((real)s->c) - logarithm(s->false_alarms_per_hour[0] / 2);
    s->limit = half_square(-log_ticks - logarithm((real)LAGS));
    s->repeat_limit = log_ticks;
}

static int is_noisy(const faults *s, size_t i, real variance)
{
    const real mean = s->smoothest[i], step = MIN_STEPS * s->resolution[i];
    return s->repeats[i] < MAX_REPEATS * s->seen[i] && mean > step * step && mean > 6 * MIN_NOISE * MIN_NOISE * variance;
}

/* A change of a value with a resolution is a multiple of it, apart from rounding errors. */
static void note_resolution(faults *s, size_t i, real change, real variance)
{
    if (change * change < ROUNDING * ROUNDING * variance) return;
    if (s->resolution[i] == 0 || change < s->resolution[i]) s->resolution[i] = change;
}

static void add_roughness(faults *s, size_t i, real square)
{
    s->roughness[i] += square;
    if (++s->rough[i] < BLOCK) return;
    const real mean = s->roughness[i] / BLOCK;
    if (s->smoothest[i] == 0 || mean < s->smoothest[i]) s->smoothest[i] = mean;
    s->roughness[i] = s->rough[i] = 0;
}

void faults_count(faults *s, size_t i, real measured, real variance)
{
    const real change = measured - s->last[i], second = change - s->last_change[i];
    s->last[i] = measured;
    if (s->seen[i] == MAX_SEEN) s->seen[i] /= 2, s->repeats[i] /= 2;
    if (s->seen[i]++ == 0) return;
    if (change != 0) {
        if (s->seen[i] > 2) add_roughness(s, i, second * second);
        note_resolution(s, i, fabs(change), variance);
        note_resolution(s, i, fabs(second), variance);
        s->last_change[i] = change;
        s->run[i] = s->evidence[i] = 0;
        return;
    }
    if (is_noisy(s, i, variance)) s->evidence[i] += logarithm(s->seen[i] + 2) - logarithm(s->repeats[i] + 1);
    s->run[i]++;
    s->repeats[i]++;
}

/* Add the sums of a tick to those of a window; the sums of PART ticks. */
static void add_tick(const faults *s, int age)
{
    const size_t at = faults_at(s, 0, s->clock[0] - age);
    real *restrict S = s->sum, *restrict I = s->information;
    for (size_t i = 0; i < s->c; i++) S[i] += s->weight[at + i] * s->residual[at + i], I[i] += s->weight[at + i];
}

static void add_part(const faults *s, int age)
{
    const size_t at = faults_at(s, 0, s->clock[0] - age);
    real *restrict S = s->sum, *restrict I = s->information;
    for (size_t i = 0; i < s->c; i++) S[i] += s->sums[at + i], I[i] += s->weights[at + i];
}

/* Note the windows that begin at a tick and exceed the threshold. */
static void compare(faults *s, real begin)
{
    for (size_t i = 0; i < s->c; i++) {
        const real S = s->sum[i], I = s->information[i], e = s->error[i], spread = 2 * (I + e * e * I * I);
        if (S * S > s->limit * spread && begin >= s->since[i] && S * S > s->level[i] * spread)
            s->level[i] = S * S / spread, s->onset[i] = begin;
    }
}

void faults_scan(faults *s)
{
    const real now = s->clock[0];
    const size_t at = faults_at(s, 0, now);
    for (size_t i = 0; i < s->c; i++) s->sum[i] = s->information[i] = s->level[i] = 0, s->onset[i] = now;
    for (int k = 0, age = 0; k < LAGS && LAG[k] <= now + 1; k++) {
        while (age < LAG[k])
            if (age < 2 * PART) add_tick(s, age++);
            else add_part(s, age), age += PART;
        for (size_t i = 0; i < s->c && age == PART; i++)
            s->sums[at + i] = s->sum[i], s->weights[at + i] = s->information[i];
        compare(s, now + 1 - (real)age);
    }
    /* Both kinds of evidence in units of their own threshold. */
    for (size_t i = 0; i < s->c; i++) {
        const real of_run = s->evidence[i] / s->repeat_limit;
        s->level[i] /= s->limit;
        if (of_run > s->level[i]) s->level[i] = of_run, s->onset[i] = now - s->run[i] + 1;
    }
}
