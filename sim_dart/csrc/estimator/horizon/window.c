#include "window.h"

#include "../../math/rows.h"
#include "../predict.h"

#include <string.h>

enum { MAX_STEPS = 50, HALVINGS = 30 };
static const real TOLERANCE = PRECISE(1e-9, 1e-3); /* of multipliers, in inverse standard deviations */

static real *multiplier_of(const horizon *h, size_t k, size_t t)
{
    return h->multiplier + k * h->multiplier_length + (size_t)h->slot[k * h->T + t];
}

/* Return h' x, with x a change of the state. */
static real along(const estimator *e, const real *row, size_t bias, const real *x)
{
    return (bias < e->N ? x[bias] : 0) + dot(3 * e->n, row, x);
}

/* Compute x <- x + factor h. */
static void add_along(const estimator *e, const real *row, size_t bias, real factor, real *x)
{
    if (bias < e->N) x[bias] += factor;
    add(3 * e->n, x, factor, row);
}

/* Compute y = A x over the interval before frame k. */
static void follow(const estimator *e, size_t k, const real *x, real *y)
{
    const size_t n = e->n, wide = 3 * n;
    const real *A = e->horizon->A + k * 2 * n * wide;
    memcpy(y + 2 * n, x + 2 * n, (e->N - 2 * n) * sizeof(real));
    for (size_t j = 0; j < 2 * n; j++) y[j] = dot(wide, A + j * wide, x);
}

/* Compute y = A' x over the interval before frame k. */
static void follow_back(const estimator *e, size_t k, const real *x, real *y)
{
    const size_t n = e->n, wide = 3 * n;
    const real *A = e->horizon->A + k * 2 * n * wide;
    memset(y, 0, 2 * n * sizeof(real));
    memcpy(y + 2 * n, x + 2 * n, (e->N - 2 * n) * sizeof(real));
    for (size_t j = 0; j < 2 * n; j++) add(wide, y, x[j], A + j * wide);
}

/* Compute the shifts for the multipliers, and the residuals of all terms. */
static void evaluate(estimator *e)
{
    horizon *h = e->horizon;
    const size_t N = e->N, wide = 3 * e->n, K = (size_t)h->frames[0];
    for (size_t k = K; k-- > 0;) {
        real *y = h->adjoint + k * N;
        memset(y, 0, N * sizeof(real));
        if (k + 1 < K) follow_back(e, k + 1, y + N, y);
        for (size_t t = 0; t < (size_t)h->count[k]; t++) {
            const real l = *multiplier_of(h, k, t);
            if (l != 0) add_along(e, h->row + (k * h->T + t) * wide, bias_of(e, (size_t)h->slot[k * h->T + t]), l, y);
        }
    }
    for (size_t k = 0; k < K; k++) {
        real *d = h->shift + k * N;
        if (k) {
            follow(e, k, d - N, d);
            for (size_t j = 0; j < N; j++) d[j] += h->defect[k * N + j];
        } else {
            for (size_t j = 0; j < N; j++) d[j] = h->arrival[j] - h->x[j];
        }
        const real *P = k ? h->Q + k * N * N : h->arrival_covariance;
        for (size_t j = 0; j < N; j++) d[j] += dot(N, P + j * N, h->adjoint + k * N);
        for (size_t t = k * h->T; t < k * h->T + (size_t)h->count[k]; t++)
            h->rest[t] = h->residual[t] - along(e, h->row + t * wide, bias_of(e, (size_t)h->slot[t]), d);
    }
}

/* Begin a pass of the filter at the first frame, or advance it to frame k. */
static void predict(estimator *e, size_t k)
{
    horizon *h = e->horizon;
    const size_t N = e->N;
    if (!k) {
        memcpy(h->P, h->arrival_covariance, N * N * sizeof(real));
        memset(h->mean, 0, N * sizeof(real));
        return;
    }
    follow(e, k, h->mean, e->gain);
    memcpy(h->mean, e->gain, N * sizeof(real));
    estimator_propagate(e, h->A + k * 6 * e->n * e->n, h->P);
    for (size_t j = 0; j < N * N; j++) h->P[j] += h->Q[k * N * N + j];
}

/* Compute P h of term t in `to`. */
static void compute_gain(estimator *e, size_t t, real *to)
{
    const horizon *h = e->horizon;
    const size_t N = e->N, bias = bias_of(e, (size_t)h->slot[t]);
    const real *row = h->row + t * 3 * e->n;
    if (bias < N)
        memcpy(to, h->P + bias * N, N * sizeof(real));
    else
        memset(to, 0, N * sizeof(real));
    for (size_t j = 0; j < 3 * e->n; j++) add(N, to, row[j], h->P + j * N);
}

/* Correct P and the mean by term t with a residual at mean 0. */
static void correct(estimator *e, size_t t, real residual)
{
    horizon *h = e->horizon;
    const size_t N = e->N, bias = bias_of(e, (size_t)h->slot[t]);
    real *k = h->gain + t * N;
    compute_gain(e, t, k);
    const real *row = h->row + t * 3 * e->n, S = h->variance[t] + along(e, row, bias, k);
    const real nu = residual - along(e, row, bias, h->mean);
    h->spread[t] = S, h->innovation[t] = nu;
    for (size_t j = 0; j < N; j++) {
        const real share = k[j] / S;
        h->mean[j] += share * nu;
        add(N, h->P + j * N, -share, k);
    }
}

/* Compute the step of the free multipliers to their minimum. */
static void compute_step(estimator *e)
{
    horizon *h = e->horizon;
    const size_t N = e->N, K = (size_t)h->frames[0];
    for (size_t k = 0; k < K; k++) {
        predict(e, k);
        for (size_t t = k * h->T; t < k * h->T + (size_t)h->count[k]; t++)
            if (h->is_free[t] != 0)
                correct(e, t, h->rest[t] - h->variance[t] * *multiplier_of(h, k, t - k * h->T));
    }
    real *r = e->gain, *back = e->shift;
    memset(r, 0, N * sizeof(real));
    for (size_t k = K; k-- > 0;) {
        for (size_t t = k * h->T + (size_t)h->count[k]; t-- > k * h->T;) {
            h->step[t] = 0;
            if (h->is_free[t] == 0) continue;
            const real *gain = h->gain + t * N;
            h->step[t] = (h->innovation[t] - dot(N, gain, r)) / h->spread[t];
            add_along(e, h->row + t * 3 * e->n, bias_of(e, (size_t)h->slot[t]), h->step[t], r);
        }
        if (!k) break;
        follow_back(e, k, r, back);
        memcpy(r, back, N * sizeof(real));
    }
}

/* Return the multiplier for a residual: the derivative of the loss. */
static real pull(const horizon *h, size_t t, real rest)
{
    return clip(rest / h->variance[t], h->least[t], h->most[t]);
}

/* For each term t of frame k. */
#define EACH_TERM(h, k, t)                                    \
    for (size_t k = 0; k < (size_t)(h)->frames[0]; k++)       \
        for (size_t t = k * (h)->T; t < k * (h)->T + (size_t)(h)->count[k]; t++)

/* Minimise with the current set of free terms, and the other multipliers at their bounds. */
static void minimise(estimator *e)
{
    horizon *h = e->horizon;
    evaluate(e);
    compute_step(e);
    EACH_TERM(h, k, t) *multiplier_of(h, k, t - k * h->T) += h->step[t];
    evaluate(e);
}

/* Return the largest error of a multiplier, times the standard deviation of its innovation. */
static real largest_error(const estimator *e)
{
    const horizon *h = e->horizon;
    real worst = 0;
    EACH_TERM(h, k, t)
    {
        const real l = *multiplier_of(h, k, t - k * h->T);
        const real right = h->is_free[t] != 0 ? clip(l, h->least[t], h->most[t]) : pull(h, t, h->rest[t]);
        const real error = fabs(l - right) * sqrt(h->spread[t]);
        if (!(error <= worst)) worst = error;
    }
    return worst;
}

/* Return the derivative of the cost along the line from the last point to the current one, at a share of it. */
static real slope_at(const estimator *e, real share)
{
    const horizon *h = e->horizon;
    real sum = 0;
    EACH_TERM(h, k, t)
    {
        const real l = *multiplier_of(h, k, t - k * h->T), change = h->last_rest[t] - h->rest[t];
        sum += (h->last[t] + share * (l - h->last[t]) - pull(h, t, h->last_rest[t] - share * change)) * change;
    }
    return sum;
}

/* Move the last point to the minimum on the line to the current point. */
static void search_line(estimator *e)
{
    horizon *h = e->horizon;
    real low = 0, high = 1;
    if (slope_at(e, 1) > 0)
        for (int half = 0; half < HALVINGS; half++) {
            const real middle = (low + high) / 2;
            *(slope_at(e, middle) > 0 ? &high : &low) = middle;
        }
    EACH_TERM(h, k, t)
    {
        h->last[t] += high * (*multiplier_of(h, k, t - k * h->T) - h->last[t]);
        h->last_rest[t] += high * (h->rest[t] - h->last_rest[t]);
    }
}

/* Use the current point as the last one. */
static void store_point(estimator *e)
{
    horizon *h = e->horizon;
    EACH_TERM(h, k, t) h->last[t] = *multiplier_of(h, k, t - k * h->T), h->last_rest[t] = h->rest[t];
}

/* Set the free terms and the other multipliers by the residuals of the last point. */
static void choose_free(estimator *e)
{
    horizon *h = e->horizon;
    EACH_TERM(h, k, t)
    {
        const real l = pull(h, t, h->last_rest[t]);
        h->is_free[t] = l > h->least[t] && l < h->most[t];
        *multiplier_of(h, k, t - k * h->T) = l;
    }
}

/* Minimise the cost. The first set of free terms is the one of the last multipliers. Return whether the steps
   converged. */
static int solve(estimator *e)
{
    horizon *h = e->horizon;
    EACH_TERM(h, k, t)
    {
        real *l = multiplier_of(h, k, t - k * h->T);
        *l = clip(*l, h->least[t], h->most[t]);
        h->is_free[t] = *l > h->least[t] && *l < h->most[t];
    }
    for (int step = 0; step < MAX_STEPS; step++) {
        minimise(e);
        h->iterations[0] += 1;
        if (largest_error(e) <= TOLERANCE) return 1;
        if (step)
            search_line(e);
        else
            store_point(e);
        choose_free(e);
    }
    return 0;
}

/* Return whether a term is a measurement that is not ignored. */
static int is_used(const horizon *h, size_t t)
{
    return (size_t)h->slot[t] < h->B && h->least[t] < 0;
}

/* Return whether the residual of a measurement exceeds the gate, in standard deviations. */
static int is_outlier(const estimator *e, const real *residual, size_t t)
{
    const horizon *h = e->horizon;
    const real size = h->most[t] > 0 || residual[t] < 0 ? fabs(residual[t]) : 0; /* slack: only below l(q) */
    return is_used(h, t) && !(size <= e->gate[0] * sqrt(h->variance[t]));
}

/* Ignore the outliers of each frame, unless they are the majority. Return their number. */
static size_t ignore_outliers(estimator *e, const real *residual, size_t frames)
{
    horizon *h = e->horizon;
    size_t count = 0;
    for (size_t k = 0; k < frames; k++) {
        const size_t first = k * h->T, end = first + (size_t)h->count[k];
        size_t all = 0, out = 0;
        for (size_t t = first; t < end; t++)
            all += (size_t)is_used(h, t), out += (size_t)is_outlier(e, residual, t);
        for (size_t t = first; t < end && 2 * out <= all; t++)
            if (is_outlier(e, residual, t)) h->least[t] = h->most[t] = 0, count++;
    }
    return count;
}

/* Compute, without the bounds of q, the mean and covariance of the second frame before its measurements, and
   the covariance of the last frame. Terms at the bounds of their multipliers act by constant forces. */
static void summarise(estimator *e)
{
    horizon *h = e->horizon;
    const size_t N = e->N, K = (size_t)h->frames[0];
    for (size_t k = 0; k < K; k++) {
        predict(e, k);
        if (!k)
            for (size_t j = 0; j < N; j++) h->mean[j] = h->arrival[j] - h->x[j];
        if (k == 1) {
            for (size_t j = 0; j < N; j++) h->next_arrival[j] = h->x[N + j] + h->defect[N + j] + h->mean[j];
            memcpy(h->next_covariance, h->P, N * N * sizeof(real));
        }
        for (size_t t = k * h->T; t < k * h->T + (size_t)h->count[k]; t++) {
            if ((size_t)h->slot[t] >= h->B) continue;
            if (h->is_free[t] != 0) {
                correct(e, t, h->residual[t]);
                continue;
            }
            compute_gain(e, t, e->gain);
            const real l = *multiplier_of(h, k, t - k * h->T);
            add(N, h->mean, l, e->gain);
        }
    }
    memcpy(e->covariance, h->P, N * N * sizeof(real));
}

int window_solve(estimator *e)
{
    horizon *h = e->horizon;
    const size_t K = (size_t)h->frames[0];
    ignore_outliers(e, h->residual, K - 1); /* of the last solution, which the new frame may change */
    int has_converged = solve(e);
    if (ignore_outliers(e, h->rest, K)) has_converged = solve(e);
    e->used[0] = 0;
    for (size_t t = (K - 1) * h->T; t < (K - 1) * h->T + (size_t)h->count[K - 1]; t++)
        if ((size_t)h->slot[t] < h->B && h->most[t] > 0) e->used[0] += 1;
    summarise(e);
    return has_converged;
}
