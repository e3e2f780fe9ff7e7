#include "horizon.h"

#include "../../math/elementary.h"
#include "../measurements.h"
#include "../predict.h"
#include "terms.h"
#include "window.h"

#include <string.h>

enum { MAX_ROUNDS = 5 };
static const real LARGE_SHIFT = 1e-2; /* of q, in [rad] or [m], after which frames are linearised again */

/* ------------------------------------------------------------------------------------------------ frames */

void horizon_begin(estimator *e, real step, int32_t steps)
{
    horizon *h = e->horizon;
    if (!h) return;
    const size_t used = (size_t)h->frames[0];
    if (used == h->K) {
        memcpy(h->before, h->x, e->N * sizeof(real));
        memcpy(h->slips_before, h->slips, e->bends * sizeof(real));
        memcpy(h->arrival, h->next_arrival, e->N * sizeof(real));
        memcpy(h->arrival_covariance, h->next_covariance, e->N * e->N * sizeof(real));
#define SHIFT(name_, length) memmove(h->name_, h->name_ + h->name_##_length, (h->K - 1) * h->name_##_length * sizeof(real));
        HORIZON_FRAMES(SHIFT)
#undef SHIFT
        h->frames[0] -= 1;
    } else if (h->has_arrival[0] == 0) {
        memcpy(h->before, e->state, e->N * sizeof(real));
        memcpy(h->slips_before, e->slips, e->bends * sizeof(real));
    }
    const size_t last = (size_t)h->frames[0];
    h->clock[2 * last] = step, h->clock[2 * last + 1] = (real)steps;
}

void horizon_append(estimator *e)
{
    horizon *h = e->horizon;
    if (!h) return;
    const size_t k = (size_t)h->frames[0];
    if (h->has_arrival[0] == 0) {
        h->has_arrival[0] = 1;
        memcpy(h->arrival, e->state, e->N * sizeof(real));
        memcpy(h->arrival_covariance, e->covariance, e->N * e->N * sizeof(real));
    }
    memcpy(h->x + k * e->N, e->state, e->N * sizeof(real));
    memcpy(h->slips + k * e->bends, e->slips, e->bends * sizeof(real));
    memcpy(h->forces + k * e->m, e->last_tensions, e->m * sizeof(real));
    memcpy(h->inputs + k * h->B, e->lengths, h->B * sizeof(real));
    memset(h->multiplier + k * h->multiplier_length, 0, h->multiplier_length * sizeof(real));
    h->frames[0] += 1;
}

/* --------------------------------------------------------------------------------------------- linearisation */

/* Compute B <- transition B in the rows of q and qd, 2 n x 3 n. */
static void multiply_transition(estimator *e, real *B)
{
    const size_t n = e->n, wide = 3 * n;
    real *C = e->product;
    for (size_t j = 0; j < 2 * n; j++)
        for (size_t l = 0; l < wide; l++) {
            real sum = l < 2 * n ? 0 : e->transition[j * wide + l];
            for (size_t k = 0; k < 2 * n; k++) sum += e->transition[j * wide + k] * B[k * wide + l];
            C[j * wide + l] = sum;
        }
    memcpy(B, C, 2 * n * wide * sizeof(real));
}

/* Advance from a state to frame k: compute A, Q, and the defect, and the slips after the steps. Return nonzero if
   a step fails. */
static int linearise_interval(estimator *e, size_t k, const real *x, const real *slips)
{
    horizon *h = e->horizon;
    const size_t n = e->n, N = e->N, wide = 3 * n;
    real *A = h->A + k * 2 * n * wide, *Q = h->Q + k * N * N;
    memset(A, 0, 2 * n * wide * sizeof(real));
    memset(Q, 0, N * N * sizeof(real));
    for (size_t j = 0; j < 2 * n; j++) A[j * wide + j] = 1;
    memcpy(e->state, x, N * sizeof(real));
    memcpy(e->slips, slips, e->bends * sizeof(real));
    for (size_t step = 0; step < (size_t)h->clock[2 * k + 1]; step++) {
        if (estimator_advance(e, h->clock[2 * k])) return 1;
        multiply_transition(e, A);
        estimator_propagate(e, e->transition, Q);
        estimator_add_noise(e, h->clock[2 * k], Q);
    }
    for (size_t j = 0; j < N; j++) h->defect[k * N + j] = e->state[j] - h->x[k * N + j];
    return 0;
}

/* Linearise the interval before frame k, and its measurements. */
static int linearise(estimator *e, size_t k)
{
    horizon *h = e->horizon;
    const size_t N = e->N, b = e->bends;
    real *x = h->x + k * N;
    memcpy(e->lengths, h->inputs + k * h->B, h->B * sizeof(real));
    memcpy(e->last_tensions, h->forces + k * e->m, e->m * sizeof(real));
    for (size_t i = 0; i < e->m; i++) e->changes[i] = k ? e->last_tensions[i] - h->forces[(k - 1) * e->m + i] : 0;
    if (k || e->i) { /* accelerometers of the first frame need the step before it */
        if (linearise_interval(e, k, k ? x - N : h->before, k ? h->slips + (k - 1) * b : h->slips_before)) return 1;
        memcpy(h->slips + k * b, e->slips, b * sizeof(real));
    }
    memcpy(e->state, x, N * sizeof(real));
    if (core_move_checked(e->core, e->state, e->state + e->n)) return 1;
    h->count[k] = 0;
    e->is_collecting = (int)k + 1;
    estimator_take_all(e);
    horizon_add_bounds(e);
    e->is_collecting = 0;
    return 0;
}

int horizon_solve(estimator *e)
{
    horizon *h = e->horizon;
    if (!h) return ESTIMATOR_TRACKING;
    const size_t K = (size_t)h->frames[0], N = e->N;
    memcpy(h->current, e->lengths, h->B * sizeof(real));
    h->iterations[0] = 0;
    int failed = 0, has_converged = 0;
    for (int round = 0; round < MAX_ROUNDS; round++) {
        for (size_t k = 0; k < K && !failed; k++) failed = linearise(e, k);
        if (failed) break;
        const int solved = window_solve(e);
        real moved = 0;
        for (size_t j = 0; j < K * N; j++) h->x[j] += h->shift[j];
        for (size_t j = 0; j < e->n; j++) moved = larger(moved, fabs(h->shift[(K - 1) * N + j]));
        has_converged = solved && !(moved > LARGE_SHIFT);
        if (!(moved > LARGE_SHIFT)) break;
    }
    memcpy(e->lengths, h->current, h->B * sizeof(real));
    if (failed) return ESTIMATOR_DIVERGED;
    memcpy(e->state, h->x + (K - 1) * N, N * sizeof(real));
    return has_converged ? ESTIMATOR_TRACKING : ESTIMATOR_NOT_CONVERGED;
}
