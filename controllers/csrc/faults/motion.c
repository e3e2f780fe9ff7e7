/* Signatures of lost forces and of loads in the innovations, see motion_filter.h. */
#include "motion_filter.h"

#include "../../../sim_dart/csrc/math/cholesky.h"
#include "hypotheses.h"

#include <string.h>

enum { AGES = 11, LAGS = 8, SHARES = 3 };
/* Possible ticks of a change before its detection, and lengths of the sums. */
static const int AGE[AGES] = {0, 1, 2, 3, 4, 6, 8, 11, 15, 20, 27};
static const int LAG[LAGS] = {1, 2, 3, 4, 6, 10, 16, 28};
static const real RISE[RISES] = {1, 2, 4, 8, 16, 32};     /* ticks in which a load grows */
/* Prior of the size of a load relative to the usual change of loads: constant for its logarithm. */
static const real SHARE[SHARES] = {1, (real)0.3, (real)0.1};

/* Advance the signature x of a load by a tick. Return its part of the white innovation in s->signal. */
static void advance_signature(faults *s, const motion_record *at, const real *load, real h, real *x)
{
    const size_t n = s->n;
    real *w = x + 2 * n;
    for (size_t j = 0; j < n; j++) w[j] += load[j];
    motion_advance(s, at->mobility, h, x);
    for (size_t j = 0; j < n; j++) w[j] -= load[j];
    memcpy(s->signal, x, n * sizeof(real));
    if (at->factor[0] == 0) return;
    motion_whiten(n, at->factor, s->signal);
    motion_add_gain(n, at->gain, s->signal, -1, x);
}

/* Return the signatures of an onset. */
static real *signatures(const faults *s, size_t o)
{
    return s->signatures + o * (RISES * s->n + SIGNS * s->m) * 3 * s->n;
}

/* Add a tick to the sums of the loads of any direction that grow for RISE[r] ticks. */
static void add_rise(faults *s, size_t o, size_t r, const motion_record *at, real age, real h)
{
    const size_t n = s->n, sum = o * RISES + r;
    real *x = signatures(s, o) + r * n * 3 * n, *score = s->load_score + sum * n, *info = s->load_info + sum * n * n;
    for (size_t j = 0; j < n; j++) {
        memset(s->solved, 0, n * sizeof(real));
        s->solved[j] = smaller((age + 1) / RISE[r], 1);
        advance_signature(s, at, s->solved, h, x + j * 3 * n);
        memcpy(s->matrix + j * n, s->signal, n * sizeof(real));
    }
    for (size_t j = 0; j < n && at->factor[0] != 0; j++) {
        score[j] += cholesky_dot(n, s->matrix + j * n, at->white);
        for (size_t k = 0; k < n; k++) info[j * n + k] += cholesky_dot(n, s->matrix + j * n, s->matrix + k * n);
    }
}

/* Add a tick to the sums of the loads that begin at an onset. */
static void add_load(faults *s, size_t o, size_t rises, const motion_record *at, real age, real h)
{
    const size_t n = s->n;
    for (size_t r = 0; r < rises; r++) add_rise(s, o, r, at, age, h);
    if (at->factor[0] == 0) return;
    s->squares[o] += cholesky_dot(n, at->white, at->white);
    s->agile[o] += *at->agile;
    s->count[o] += (real)n;
}

/* Add a tick to the sums of the muscles: the loads of the force, of 1 N, of a spring of 1 N/m, and of the
   force in the first tick. */
static void add_muscles(faults *s, size_t o, const motion_record *at, int is_first, real h)
{
    const size_t n = s->n, m = s->m;
    real *x = signatures(s, o) + RISES * n * 3 * n;
    for (size_t i = 0; i < m; i++) {
        const real scale[SIGNS] = {at->forces[i], 1, at->lengths[i] - s->length_began[o * m + i],
                                   is_first ? at->forces[i] : 0};
        real *score = s->score + (o * m + i) * SIGNS, *info = s->info + (o * m + i) * SIGNS * SIGNS;
        for (size_t k = 0; k < SIGNS; k++, x += 3 * n) {
            for (size_t j = 0; j < n; j++) s->solved[j] = scale[k] * at->jacobian[i * n + j];
            advance_signature(s, at, s->solved, h, x);
            memcpy(s->matrix + k * n, s->signal, n * sizeof(real));
        }
        for (size_t k = 0; k < SIGNS && at->factor[0] != 0; k++) {
            score[k] += cholesky_dot(n, s->matrix + k * n, at->white);
            for (size_t l = 0; l < SIGNS; l++)
                info[k * SIGNS + l] += cholesky_dot(n, s->matrix + k * n, s->matrix + l * n);
        }
    }
}

static void clear(faults *s, size_t o)
{
    const size_t n = s->n, m = s->m;
    memset(signatures(s, o), 0, (RISES * n + SIGNS * m) * 3 * n * sizeof(real));
    memset(s->load_score + o * RISES * n, 0, RISES * n * sizeof(real));
    memset(s->load_info + o * RISES * n * n, 0, RISES * n * n * sizeof(real));
    memset(s->score + o * m * SIGNS, 0, m * SIGNS * sizeof(real));
    memset(s->info + o * m * SIGNS * SIGNS, 0, m * SIGNS * SIGNS * sizeof(real));
    s->squares[o] = s->count[o] = s->agile[o] = 0;
}

/* Log Bayes factor of a load that grows for RISE[r] ticks from an onset, with a share of the usual change of loads. */
static real log_factor_of_change(faults *s, size_t o, size_t r, real share)
{
    const size_t n = s->n, at = o * RISES + r;
    real *solved = s->solved, sum = 0;
    for (size_t j = 0; j < n; j++) {
        const real change = share * s->load_change[j];
        for (size_t k = 0; k < n; k++) s->matrix[j * n + k] = s->load_info[(at * n + j) * n + k];
        s->matrix[j * n + j] += 1 / (change * change);
        solved[j] = s->load_score[at * n + j];
        sum -= logarithm(change);
    }
    if (motion_decompose(n, s->matrix, s->signal_factor)) return 0;
    motion_whiten(n, s->signal_factor, solved);
    for (size_t j = 0; j < n; j++) sum += logarithm(s->signal_factor[j * n + j]);
    return sum + cholesky_dot(n, solved, solved) / 2;
}

/* The most probable one of: a load that grows for some ticks, of any size if a load has changed before; changing loads; larger
   innovations. */
static real log_factor_of_load(faults *s, size_t o, size_t rises)
{
    const real N = s->count[o], mean = s->squares[o] / larger(N, 1);
    real best = larger(s->agile[o], mean > 1 ? N * (mean - 1 - logarithm(mean)) / 2 : 0);
    const size_t shares = s->loaded[0] != 0 ? SHARES : 1;
    for (size_t r = 0; r < rises; r++)
        for (size_t k = 0; k < shares; k++) best = larger(best, log_factor_of_change(s, o, r, SHARE[k]));
    return best;
}

static real oldest(const faults *s)
{
    return larger(s->motion_begin[0] + 1, s->clock[0] - MOTION_WINDOW + 1);
}

/* Compute the signatures from the last onsets near a tick; those of the best one and its neighbours are kept. */
static void follow(faults *s, real first, real last, real h)
{
    for (size_t o = 0; o < ONSETS; o++) {
        clear(s, o);
        s->began[o] = smaller(larger(first + (real)o, oldest(s)), last);
        const motion_record before = motion_at(s, larger(s->began[o] - 1, oldest(s)));
        memcpy(s->force_began + o * s->m, before.forces, s->m * sizeof(real));
        memcpy(s->length_began + o * s->m, before.lengths, s->m * sizeof(real));
        for (real t = s->began[o]; t <= last; t++) {
            const motion_record at = motion_at(s, t);
            add_load(s, o, RISES, &at, t - s->began[o], h), add_muscles(s, o, &at, t == s->began[o], h);
        }
    }
    s->followed[0] = 0;
}

/* Return whether a sum of white innovations exceeds its threshold. */
static int is_changed(const faults *s)
{
    const size_t n = s->n;
    const real now = s->clock[0];
    real *sum = s->signal, N = 0;
    memset(sum, 0, n * sizeof(real));
    for (int k = 0, lag = 0; lag < LAGS && now - k >= oldest(s); k++) {
        const motion_record at = motion_at(s, now - k);
        for (size_t j = 0; j < n && at.factor[0] != 0; j++) sum[j] += at.white[j];
        N += at.factor[0] != 0;
        if (k + 1 != LAG[lag]) continue;
        lag++;
        for (size_t j = 0; j < n; j++)
            if (sum[j] * sum[j] > 2 * s->limit * N) return 1;
    }
    return 0;
}

/* Return the most probable tick of the begin of a load. */
static real find_onset(faults *s, real h)
{
    const real now = s->clock[0];
    real best = 0, onset = now;
    for (int k = 0; k < AGES && now - AGE[k] >= oldest(s); k++) {
        clear(s, 0);
        for (real t = now - AGE[k]; t <= now; t++) {
            const motion_record at = motion_at(s, t);
            add_load(s, 0, 1, &at, 0, h);
        }
        const real factor = log_factor_of_load(s, 0, 1);
        if (factor > best) best = factor, onset = now - AGE[k];
    }
    return onset;
}

real faults_load_factor(faults *s)
{
    real best = 0;
    for (size_t o = 0; s->followed[0] >= 0 && o < ONSETS; o++) best = larger(best, log_factor_of_load(s, o, RISES));
    return best;
}

fault_fit faults_fit_moved(const faults *s, size_t i, enum fault_kind kind, real *begin)
{
    fault_fit best = {s->followed[0] < 0 ? 0 : -(real)1e9, 0};
    for (size_t o = 0; s->followed[0] >= 0 && o < ONSETS; o++) {
        const size_t at = o * s->m + i;
        const real *S = s->score + at * SIGNS, *I = s->info + at * SIGNS * SIGNS;
        const fault_fit fit = kind == FAULT_BROKEN ? faults_fit_break(S, I)
                              : kind == FAULT_WEAK ? faults_fit_weakness(S, I)
                                                   : faults_fit_spring(s, i, S, I, s->force_began[at]);
        if (fit.factor > best.factor) best = fit, *begin = s->began[o];
    }
    return best;
}

/* Return a length or encoder that is suspect, or c. */
static size_t suspect_geometry(const faults *s)
{
    size_t i = 0;
    while (i < s->c && (s->suspicion[i] < 0 || (i >= s->m && i < 2 * s->m))) i++;
    return i;
}

/* Return whether the motion is to be compared: without tension sensors, with a pose. */
static int is_compared(const faults *s)
{
    int is_compared = faults_is_measured(s->load_change[0]) && s->factor[0] > 0;
    for (size_t i = 0; i < s->m; i++) is_compared &= !faults_is_number(s->tensions[i]);
    return is_compared;
}

int faults_follow_motion(faults *s, real h, int steps)
{
    const real now = s->clock[0];
    const size_t suspect = suspect_geometry(s);
    /* the fit contains a sensor that has become suspect in this tick */
    if (!is_compared(s) || !motion_filter(s, h, steps, suspect == s->c || s->suspicion[suspect] < now)) return 0;
    if (s->followed[0] >= 0) {
        const motion_record record = motion_at(s, now);
        for (size_t o = 0; o < ONSETS; o++)
            add_load(s, o, RISES, &record, now - s->began[o], h), add_muscles(s, o, &record, 0, h);
        s->followed[0]++;
    } else if (suspect < s->m && s->onset[suspect] > oldest(s)) {
        follow(s, s->onset[suspect] - 1, now, h);
    } else if (suspect == s->c && is_changed(s)) {
        const real onset = find_onset(s, h);
        if (onset - s->motion_begin[0] < WINDOW) faults_accept_load(s, 1); /* the last change of the load continues */
        else follow(s, onset - 1, now, h);
    }
    return s->followed[0] >= 0 && suspect == s->c;
}
