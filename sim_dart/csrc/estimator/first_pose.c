/* Search of the first pose from one sample: min |r(q)|^2, with r the residuals over their standard
   deviations, by the Levenberg-Marquardt method from several starts. Two poses differ if their distance is
   large compared to the uncertainty of the measurements. Both fit if their sums of squares are about the
   same. */
#include "../math/cholesky.h"
#include "../math/elementary.h"
#include "state.h"

#include <string.h>

enum { MAX_STEPS = 30 };
static const real FIRST_DAMPING = PRECISE(1e-3, 1e-3), MIN_DAMPING = PRECISE(1e-9, 1e-5);
static const real MAX_DAMPING = 1e8;
static const real SMALL_STEP = PRECISE(1e-10, 1e-5); /* in rad or m */
static const real SAME_POSE = 25;  /* squared distance over variance within which poses are equal */
static const real SAME_FIT = 25; /* difference of sums of squares within which both poses fit */
static const real POOR_FIT = 25;  /* mean square above which a pose does not fit */

/* Return the standard deviation of a length with a constant but unknown offset. */
static real length_sd(const estimator *e, size_t k)
{
    const real noise = e->length_noise[k], sd = e->o ? e->start_offset_sd[k] : 0;
    return sd > 0 ? sqrt(noise * noise + sd * sd) : noise;
}

/* Move to a pose. Return the sum of squares. */
static real move_to_pose(estimator *e, const real *q, size_t *count)
{
    const core *c = e->core;
    real sum = 0;
    *count = 0;
    core_move(e->core, q);
    for (size_t k = 0; k < e->m; k++)
        if (is_taut(e, k)) {
            const real r = (path_length(e, k) - c->lengths[k]) / length_sd(e, k);
            sum += r * r, ++*count;
        }
    for (size_t j = 0; j < e->n; j++)
        if (is_measured(e->encoder_noise[j]) && is_number(e->encoders[j])) {
            const real r = (e->encoders[j] - q[j]) / e->encoder_noise[j];
            sum += r * r, ++*count;
        }
    return sum;
}

/* Compute at the last pose H = J'J in `matrix` and g = J'r in `column`, with J the derivatives of the
   measurements. */
static void normal_equations(estimator *e, const real *q)
{
    const size_t n = e->n;
    const core *c = e->core;
    memset(e->matrix, 0, n * n * sizeof(real));
    memset(e->column, 0, n * sizeof(real));
    for (size_t k = 0; k < e->m; k++) {
        if (!is_taut(e, k)) continue;
        const real *L = c->jacobian + k * n, weight = 1 / (length_sd(e, k) * length_sd(e, k));
        const real r = path_length(e, k) - c->lengths[k];
        for (size_t i = 0; i < n; i++) {
            e->column[i] += weight * L[i] * r;
            for (size_t j = 0; j < n; j++) e->matrix[i * n + j] += weight * L[i] * L[j];
        }
    }
    for (size_t j = 0; j < n; j++)
        if (is_measured(e->encoder_noise[j]) && is_number(e->encoders[j])) {
            const real weight = 1 / (e->encoder_noise[j] * e->encoder_noise[j]);
            e->column[j] += weight * (e->encoders[j] - q[j]);
            e->matrix[j * n + j] += weight;
        }
}

/* Compute a damped step within the range. Return its size; `next` is the resulting pose. */
static real try_step(estimator *e, const real *q, real damping, real *next)
{
    const size_t n = e->n;
    real *way = e->pose + 2 * n, size = 0, *damped = e->differential;
    memcpy(damped, e->matrix, n * n * sizeof(real));
    for (size_t j = 0; j < n; j++) damped[j * n + j] += damping * (e->matrix[j * n + j] + 1);
    memcpy(way, e->column, n * sizeof(real));
    if (cholesky_factor(n, damped, e->factor)) return -1;
    cholesky_solve(n, e->factor, way);
    for (size_t j = 0; j < n; j++) {
        next[j] = smaller(larger(q[j] + way[j], e->start_low[j]), e->start_high[j]);
        size = larger(size, fabs(next[j] - q[j]));
    }
    return size;
}

/* Minimise from a pose, in place. Return the sum of squares. */
static real descend(estimator *e, real *q)
{
    const size_t n = e->n;
    real *next = e->pose + n, damping = FIRST_DAMPING;
    size_t count;
    real cost = move_to_pose(e, q, &count);
    for (int step = 0; step < MAX_STEPS; step++) {
        normal_equations(e, q);
        real size, then;
        for (;;) {
            size = try_step(e, q, damping, next);
            then = size < 0 ? INFINITY : move_to_pose(e, next, &count);
            if (then <= cost || damping > MAX_DAMPING) break;
            damping *= 8;
        }
        if (!(then <= cost)) break;
        memcpy(q, next, n * sizeof(real));
        cost = then;
        damping = larger(damping / 8, MIN_DAMPING);
        if (size < SMALL_STEP) break;
    }
    return cost;
}

/* Compute a start. The first one is from the settings; the others fill the range evenly (additive recurrence
   with the powers of g, g^(n + 1) = g + 1: Roberts 2018). */
static void start_at(const estimator *e, size_t number, real *q)
{
    const size_t n = e->n;
    real g = 2, power = 1;
    for (int k = 0; k < 40; k++) g = exponential(logarithm(1 + g) / (real)(n + 1));
    for (size_t j = 0; j < n; j++) {
        power /= g;
        const real turn = (real)0.5 + power * (real)number;
        const real share = turn - (real)(int32_t)turn;
        q[j] = number ? e->start_low[j] + share * (e->start_high[j] - e->start_low[j])
                      : smaller(larger(e->start[j], e->start_low[j]), e->start_high[j]);
    }
}

/* Return (a - b)'H(a - b), with the H of the last normal equations. */
static real distance(const estimator *e, const real *a, const real *b)
{
    const size_t n = e->n;
    real sum = 0;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) sum += (a[i] - b[i]) * e->matrix[i * n + j] * (a[j] - b[j]);
    return sum;
}

/* Store the minimum sum of squares, and the minimum of a different pose. */
static void store_best(estimator *e, const real *q, real cost)
{
    const size_t n = e->n;
    real *best = e->first_poses, *second = best + n, *costs = best + 2 * n;
    normal_equations(e, q);
    if (cost < costs[0]) {
        if (distance(e, q, best) > SAME_POSE) {
            memcpy(second, best, n * sizeof(real));
            costs[1] = costs[0];
        }
        memcpy(best, q, n * sizeof(real));
        costs[0] = cost;
    } else if (cost < costs[1] && distance(e, q, best) > SAME_POSE) {
        memcpy(second, q, n * sizeof(real));
        costs[1] = cost;
    }
}

/* Set the covariances of q and the offsets: an offset that is larger by b moves the pose by -C L' b / variance, with
   C = (J'J)^-1. */
static void correlate_offsets(estimator *e)
{
    const size_t n = e->n, N = e->N;
    for (size_t k = 0; k < e->m && e->o; k++) {
        if (!is_taut(e, k)) continue;
        const size_t at = offset_state(e, k);
        const real share = e->covariance[at * N + at] / (length_sd(e, k) * length_sd(e, k));
        memcpy(e->column, e->core->jacobian + k * n, n * sizeof(real));
        cholesky_solve(n, e->factor, e->column);
        for (size_t j = 0; j < n; j++)
            e->covariance[j * N + at] = e->covariance[at * N + j] = -share * e->column[j];
    }
}

/* Set P of q to (J'J)^-1 at the best pose, limited by the range. Return 1 if J'J is singular. */
static int use_best_pose(estimator *e)
{
    const size_t n = e->n, N = e->N;
    size_t count;
    move_to_pose(e, e->first_poses, &count);
    normal_equations(e, e->first_poses);
    for (size_t j = 0; j < n; j++) {
        const real range = e->start_high[j] - e->start_low[j];
        if (range > 0) e->matrix[j * n + j] += 1 / (range * range);
    }
    if (cholesky_factor(n, e->matrix, e->factor)) return 1;
    estimator_reset(e);
    memcpy(e->state, e->first_poses, n * sizeof(real));
    for (size_t j = 0; j < n; j++) {
        real *column = e->covariance + j * N;
        memset(column, 0, n * sizeof(real));
        column[j] = 1;
        cholesky_solve(n, e->factor, column);
    }
    correlate_offsets(e);
    return 0;
}

int estimator_find(estimator *e)
{
    const size_t n = e->n;
    real *costs = e->first_poses + 2 * n;
    size_t count = 0;
    costs[0] = costs[1] = INFINITY;
    for (size_t number = 0; number < (size_t)e->starts[0]; number++) {
        start_at(e, number, e->pose);
        const real cost = descend(e, e->pose);
        move_to_pose(e, e->pose, &count);
        if (count < n) return ESTIMATOR_UNOBSERVABLE;
        store_best(e, e->pose, cost);
    }
    if (!(costs[0] <= POOR_FIT * (real)count)) return ESTIMATOR_NO_FIT;
    if (costs[1] - costs[0] < SAME_FIT) return ESTIMATOR_AMBIGUOUS;
    return use_best_pose(e) ? ESTIMATOR_UNOBSERVABLE : ESTIMATOR_TRACKING;
}
