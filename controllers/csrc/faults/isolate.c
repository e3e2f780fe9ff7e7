/* Isolation: the hypothesis with the largest Bayes factor, if its probability is large enough.

   All hypotheses have the same prior probability. Until the most probable one has MIN_CONFIDENCE, the channel remains
   suspect and is not used; after MAX_WAIT ticks the most probable one is reported with its confidence. */
#include "hypotheses.h"

enum { MAX_WAIT = WINDOW, HYPOTHESES = 16, MAX_FOLLOWED = WINDOW };
/* Possible ticks of a fault before the suspicion. */
enum { BEGINS = 11 };
static const int BEFORE[BEGINS] = {0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32};
static const real MIN_CONFIDENCE = (real)0.99; /* chosen: one wrong cause in 100 is accepted */
static const real MIN_FACTOR = (real)4.595; /* logarithm of the odds of MIN_CONFIDENCE */

typedef struct {
    enum fault_kind kind;
    size_t part, other; /* other: SIZE_MAX if there is none */
    fault_fit fit;
    real begin;
} hypothesis;

typedef struct {
    hypothesis list[HYPOTHESES];
    size_t count;
} hypotheses;

static __attribute__((noinline)) void add(hypotheses *all, enum fault_kind kind, size_t part, fault_fit fit, real begin)
{
    for (size_t k = 0; k < all->count; k++)
        if (all->list[k].kind == kind) {
            if (fit.factor > all->list[k].fit.factor) all->list[k].fit = fit, all->list[k].begin = begin;
            return;
        }
    const hypothesis one = {kind, part, (size_t)-1, fit, begin};
    all->list[all->count++] = one;
}

static int is_available(const faults *s, size_t channel)
{
    return s->weight[faults_at(s, channel, s->clock[0])] > 0;
}

/* Add a broken cable and a jammed motor, which hold the measured length and change the motion. A jammed motor need not
   change it. If the motion is not known, a cable is broken only if its length is equal in all ticks. */
static void add_moved(faults *s, size_t i, fault_fit stuck, fault_fit hold, real begin, hypotheses *all)
{
    real moved;
    if (s->motion_begin[0] < 0) return;
    const int is_known = s->followed[0] >= 0;
    fault_fit jammed = faults_fit_moved(s, i, FAULT_JAMMED, &moved);
    fault_fit broken = faults_fit_moved(s, i, FAULT_BROKEN, &moved);
    jammed.factor = hold.factor + larger(jammed.factor, 0);
    broken.factor += is_known ? larger(stuck.factor, hold.factor) : stuck.factor;
    add(all, FAULT_BROKEN, i, broken, begin);
    add(all, FAULT_JAMMED, i, jammed, begin);
}

/* Add the hypotheses of a muscle and its sensors for one begin. */
static void add_muscle(faults *s, size_t i, real begin, hypotheses *all)
{
    const size_t m = s->m, tension = m + i;
    const int has_tension = is_available(s, tension);
    const fault_fit stuck = faults_fit_stuck(s, i, begin), bias = faults_fit_bias(s, i, begin);
    add(all, FAULT_LENGTH_STUCK, m + i, stuck, begin);
    add(all, FAULT_LENGTH_BIAS, m + i, bias, begin);
    add(all, FAULT_LENGTH_SCALE, m + i, faults_fit_scale(s, i, begin), begin);
    const fault_fit hold = faults_fit_hold(s, i, begin);
    if (!has_tension) {
        add_moved(s, i, stuck, hold, begin, all);
        return;
    }
    const fault_fit dead = faults_fit_dead(s, tension, begin);
    const fault_fit broken = {dead.factor + larger(stuck.factor, bias.factor), 0};
    add(all, FAULT_TENSION_DEAD, m + tension, dead, begin);
    add(all, FAULT_BROKEN, i, broken, begin);
    add(all, FAULT_WEAK, i, faults_fit_weak(s, tension, begin), begin);
    fault_fit jam = faults_fit_jam(s, tension, begin);
    jam.factor += larger(hold.factor, 0);
    add(all, FAULT_JAMMED, i, jam, begin);
    const fault_fit frozen = faults_fit_stuck(s, tension, begin);
    add(all, FAULT_TENSION_STUCK, m + tension, frozen, begin);
}

/* Add the muscle whose length the sensor of a muscle measures. */
static void add_swap(const faults *s, size_t i, real begin, hypotheses *all)
{
    fault_fit best = {0, 0};
    size_t other = i;
    for (size_t k = 0; k < s->m; k++) {
        if (k == i || !is_available(s, k)) continue;
        fault_fit fit = faults_fit_swap(s, i, k, begin);
        fit.factor += faults_fit_swap(s, k, i, begin).factor;
        if (fit.factor > best.factor) best = fit, other = k;
    }
    if (other == i) return;
    add(all, FAULT_LENGTH_SWAPPED, s->m + i, best, begin);
    for (size_t k = 0; k < all->count; k++)
        if (all->list[k].kind == FAULT_LENGTH_SWAPPED && all->list[k].begin == begin) all->list[k].other = other;
}

static real probability(const hypotheses *all, size_t best)
{
    real sum = 0;
    for (size_t k = 0; k < all->count; k++) {
        const real difference = all->list[k].fit.factor - all->list[best].fit.factor;
        sum += difference > -50 ? exponential(difference) : 0;
    }
    return 1 / sum;
}

/* Windows of all channels begin again after a decision, since the fault may have changed their residuals. */
static void restart(faults *s, size_t channel)
{
    s->since[channel] = s->clock[0] + 1;
}

static void report(faults *s, const hypothesis *cause, size_t part, size_t other, real h_now, real confidence)
{
    s->kind[part] = (real)cause->kind;
    s->time[part] = s->now[0];
    s->begin[part] = s->now[0] - (s->clock[0] - cause->begin) * h_now;
    s->statistic[part] = cause->fit.factor;
    s->threshold[part] = s->limit;
    s->confidence[part] = confidence;
    s->value[part] = cause->fit.value;
    s->other[part] = other == (size_t)-1 ? -1 : (real)other;
    s->usable[part] = cause->kind == FAULT_WEAK;
}

static __attribute__((noinline)) void release(faults *s, size_t channel)
{
    s->suspicion[channel] = -1;
    s->suspect[faults_part(s, channel)] = 0;
    restart(s, channel);
}

/* Apply a decision on a muscle: which parts cannot be used, and the force that remains. */
static __attribute__((noinline)) void decide(faults *s, size_t i, const hypothesis *cause, real step, real confidence)
{
    const size_t m = s->m;
    report(s, cause, cause->part, cause->other, step, confidence);
    release(s, i), release(s, m + i);
    if (cause->kind == FAULT_LENGTH_SWAPPED) {
        release(s, cause->other);
        report(s, cause, m + cause->other, i, step, confidence);
    }
    if (cause->kind == FAULT_BROKEN || cause->kind == FAULT_JAMMED) s->usable[m + i] = 0;
    if (cause->kind == FAULT_BROKEN) s->bound[i] = 0;
    if (cause->kind == FAULT_WEAK) s->bound[i] = larger(cause->fit.value, 0) * s->f_max[i];
    if (cause->kind == FAULT_JAMMED) s->bound[i] = s->predicted[faults_at(s, m + i, cause->begin)];
    for (size_t k = 2 * m; k < s->c; k++) release(s, k);
    for (size_t k = 0; k < s->c; k++) restart(s, k);
    faults_forget_motion(s);
}

static void isolate_muscle(faults *s, size_t i)
{
    const size_t m = s->m;
    const real a = s->suspicion[i], b = s->suspicion[m + i], now = s->clock[0];
    const real first = a < 0 ? b : b < 0 ? a : smaller(a, b);
    hypotheses all = {.count = 0};
    const real earliest = larger(now - WINDOW + 2, 1);
    for (int k = 0; k < BEGINS; k++) {
        const real begin = larger(earliest, first - BEFORE[k]);
        add_muscle(s, i, begin, &all);
        add_swap(s, i, begin, &all);
        if (begin == earliest) break;
    }
    add_muscle(s, i, larger(earliest, now - s->run[i]), &all);
    add_muscle(s, i, larger(earliest, now - s->run[m + i]), &all);
    size_t best = 0;
    for (size_t k = 1; k < all.count; k++)
        if (all.list[k].fit.factor > all.list[best].fit.factor) best = k;
    const real confidence = probability(&all, best);
    const int is_fault = all.list[best].fit.factor > 0;
    if ((confidence < MIN_CONFIDENCE || !is_fault) && now - first < MAX_WAIT) return;
    if (!is_fault) { /* the deviation has vanished */
        release(s, i), release(s, m + i);
        return;
    }
    decide(s, i, &all.list[best], s->step, confidence);
}

/* A changed pair of lengths can look like an error of an encoder, but then the lengths become suspect too. */
static void isolate_encoder(faults *s, size_t channel)
{
    if (s->run[channel] == 0 && s->clock[0] - s->suspicion[channel] < MAX_WAIT) return;
    const hypothesis cause = {FAULT_ENCODER_STUCK, faults_part(s, channel), (size_t)-1,
                              {s->level[channel] * s->limit, 0}, s->onset[channel]};
    report(s, &cause, cause.part, cause.other, s->step, 1);
    release(s, channel);
    for (size_t k = 0; k < s->c; k++) restart(s, k);
    faults_forget_motion(s);
}

/* The hypothesis of a kind from the motion; the motor of a broken cable or a jammed motor may hold the length. */
static __attribute__((noinline)) hypothesis lost_force(const faults *s, size_t i, enum fault_kind kind)
{
    hypothesis lost = {kind, i, (size_t)-1, {0, 0}, s->clock[0]};
    lost.fit = faults_fit_moved(s, i, kind, &lost.begin);
    if (kind == FAULT_BROKEN) lost.fit.factor += s->evidence[i];
    if (kind == FAULT_JAMMED) lost.fit.factor += larger(faults_fit_hold(s, i, lost.begin).factor, 0);
    return lost;
}

/* Find the most probable lost force among all muscles but `except`, and the sum of all probabilities relative to it.
   Return whether there is one. */
static int find_lost(const faults *s, size_t except, hypothesis *best, real *sum)
{
    *sum = 0;
    for (size_t i = 0; i < s->m; i++)
        for (int kind = FAULT_BROKEN; kind <= FAULT_WEAK && i != except && s->kind[i] == 0; kind++) {
            const hypothesis candidate = lost_force(s, i, (enum fault_kind)kind);
            const real difference = *sum > 0 ? candidate.fit.factor - best->fit.factor : 0;
            const real ratio = exponential(larger(-fabs(difference), -50));
            if (*sum > 0 && difference <= 0) *sum += ratio;
            else *sum = *sum * ratio + 1, *best = candidate;
        }
    return *sum > 0;
}

/* Return whether a length may be held, so that its muscle may be lost. */
static int is_held(const faults *s)
{
    int is_held = 0;
    for (size_t i = 0; i < s->m; i++) is_held |= s->evidence[i] > 0;
    return is_held;
}

/* A lost force is more probable than an unknown load by the factor of the stated false alarms; as long as no load has
   changed, loads change at most once per window. If the muscle remains uncertain, the two most probable ones are
   reported. */
void faults_isolate_motion(faults *s, real h)
{
    hypothesis best, second;
    real sum, rest;
    if (!find_lost(s, s->m, &best, &sum)) return;
    const real factor = best.fit.factor, load = faults_load_factor(s), wait = s->followed[0];
    const real limit = s->repeat_limit - (s->loaded[0] != 0 ? 0 : logarithm((real)WINDOW));
    if (!(factor > s->repeat_limit && factor - load > limit)) {
        if ((load - factor > MIN_FACTOR && !is_held(s)) || wait > MAX_FOLLOWED) faults_accept_load(s, 1);
        return;
    }
    const real confidence = 1 / sum;
    if (confidence < MIN_CONFIDENCE && wait < MAX_WAIT) return;
    if (confidence < MIN_CONFIDENCE && find_lost(s, best.part, &second, &rest) &&
        factor - second.fit.factor < MIN_FACTOR) {
        best.other = second.part, second.other = best.part;
        decide(s, second.part, &second, h, confidence * exponential(second.fit.factor - factor));
    }
    decide(s, best.part, &best, h, confidence);
}

void faults_isolate(faults *s)
{
    for (size_t i = 0; i < s->m; i++)
        if (s->suspicion[i] >= 0 || s->suspicion[s->m + i] >= 0) isolate_muscle(s, i);
    for (size_t i = 2 * s->m; i < s->c; i++)
        if (s->suspicion[i] >= 0) isolate_encoder(s, i);
}
