/* Prediction: x <- step(x, f), P <- A P A' + Q. */
#include "predict.h"

#include "../cable_friction/cable_friction.h"
#include "../math/cholesky.h"
#include "horizon/frames.h"

#include <string.h>

/* Compute W = (M + h D + h^2 K)^-1 in `matrix`: the change of accelerations per load, as in core_step.
   Return 0, or 1 if the matrix is singular. */
static int invert_mass(estimator *e, real h)
{
    const size_t n = e->n;
    core *c = e->core;
    core_mass_matrix(c);
    for (size_t j = 0; j < n; j++)
        c->mass_matrix[j * n + j] += h * (c->blob.damping[j] + h * c->blob.stiffness[j]);
    cable_friction_resist(c, c->mass_matrix); /* as in the last step */
    if (cholesky_factor(n, c->mass_matrix, e->factor)) return 1;
    for (size_t j = 0; j < n; j++) {
        memset(e->matrix + j * n, 0, n * sizeof(real));
        e->matrix[j * n + j] = 1;
        cholesky_solve(n, e->factor, e->matrix + j * n);
    }
    return 0;
}

/* Compute the derivatives of q+ and qd+ by q, qd and w, at the state before the step. */
static int fill_transition(estimator *e, const real *q, const real *qd, const real *f, real h)
{
    const size_t n = e->n;
    real *A = e->transition, *exact = e->differential;
    if (invert_mass(e, h)) return 1;
    if (!e->exact) {
        memset(exact, 0, 4 * n * n * sizeof(real));
        for (size_t j = 0; j < 2 * n; j++) exact[j * 2 * n + j] = 1;
        for (size_t j = 0; j < n; j++) exact[j * 2 * n + n + j] = h;
    } else if (e->exact(e->exact_self, q, qd, f, e->load, h, exact)) {
        return 1;
    }
    for (size_t j = 0; j < 2 * n; j++) {
        const real share = j < n ? h * h : h;
        memcpy(A + j * 3 * n, exact + j * 2 * n, 2 * n * sizeof(real));
        for (size_t k = 0; k < n; k++) A[j * 3 * n + 2 * n + k] = -share * e->matrix[(j % n) * n + k];
    }
    return 0;
}

static real variance_of_tension(const estimator *e, size_t k, real f)
{
    const real noise = e->tension_noise[k], error = e->tension_error[k] * f;
    return noise * noise + error * error;
}

/* Compute the covariance W L' diag(s^2) L W of accelerations, with the standard deviations s of the tensions. A tension that
   changes by more than its noise, as of a broken cable, did so at an unknown time of the tick, which is uniformly distributed:
   the mean square of the error of its mean is a third of the squared change. */
static void fill_jitter(estimator *e)
{
    const size_t n = e->n;
    memset(e->jitter, 0, n * n * sizeof(real));
    for (size_t k = 0; k < e->m; k++) {
        const real f = e->last_tensions[k], square = e->changes[k] * e->changes[k], *L = e->core->jacobian + k * n;
        const real white = variance_of_tension(e, k, f), both = white + variance_of_tension(e, k, f - e->changes[k]);
        if (both == 0) continue;
        const real variance = white + (square > e->gate[0] * e->gate[0] * both ? square / 3 : 0);
        for (size_t i = 0; i < n; i++) e->column[i] = cholesky_dot(n, e->matrix + i * n, L);
        for (size_t i = 0; i < n; i++)
            for (size_t j = 0; j < n; j++) e->jitter[i * n + j] += variance * e->column[i] * e->column[j];
    }
}

void estimator_propagate(const estimator *e, const real *A, real *P)
{
    const size_t n = e->n, N = e->N, top = 2 * n, wide = 3 * n;
    real *B = e->product;
    memset(B, 0, top * N * sizeof(real));
    for (size_t j = 0; j < top; j++)
        for (size_t k = 0; k < wide; k++) {
            const real a = A[j * wide + k], *from = P + k * N;
            real *to = B + j * N;
            if (a == 0) continue;
            for (size_t l = 0; l < N; l++) to[l] += a * from[l];
        }
    for (size_t j = 0; j < top; j++) {
        for (size_t k = 0; k <= j; k++)
            P[j * N + k] = P[k * N + j] = cholesky_dot(wide, B + j * N, A + k * wide);
        for (size_t l = top; l < N; l++) P[j * N + l] = P[l * N + j] = B[j * N + l];
    }
}

/* Add the covariance v of the velocities i and k, and of the positions after a step. */
static void add_velocity_noise(const estimator *e, size_t i, size_t k, real v, real h, real *P)
{
    const size_t n = e->n, N = e->N;
    P[i * N + k] += h * h * v;
    P[i * N + n + k] += h * v;
    P[(n + i) * N + k] += h * v;
    P[(n + i) * N + n + k] += v;
}

/* Add the noise of an unknown impact that stops coordinate j: an impulse changes all velocities by M^-1. */
static void add_impact(const estimator *e, size_t j, real h, real *P)
{
    const size_t n = e->n;
    const real *response = e->matrix + j * n, scale = e->state[n + j] / response[j];
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < n; k++) add_velocity_noise(e, i, k, scale * response[i] * scale * response[k], h, P);
}

void estimator_add_noise(const estimator *e, real h, real *P)
{
    const size_t n = e->n, N = e->N;
    for (size_t j = 0; j < n; j++) {
        const real a = e->acceleration_noise[j], w = e->load_drift[j];
        for (size_t k = 0; k < n; k++)
            add_velocity_noise(e, j, k, ((k == j ? a * a : 0) + e->jitter[j * n + k] * e->interval) * h, h, P);
        P[(2 * n + j) * N + 2 * n + j] += w * w * h;
    }
    for (size_t k = 3 * n; k < N; k++) {
        const size_t first = N - e->o;
        const real drift = k < first ? e->bias_drift[(k - 3 * n) % 6 / 3] : e->offset_drift[k - first];
        P[k * N + k] += drift * drift * h;
    }
    for (size_t j = 0; j < n && e->horizon; j++)
        if (horizon_approaches_bound(e, j)) add_impact(e, j, h, P);
}

int estimator_advance(estimator *e, real h)
{
    core *c = e->core;
    const size_t n = e->n;
    real *q = e->state, *qd = q + n, *w = qd + n;
    e->step = h;
    for (size_t j = 0; j < n; j++) e->load[j] = (is_number(e->torques[j]) ? e->torques[j] : 0) - w[j];
    real *slips = c->law_states + (c->blob.law_states - c->blob.counts.bends);
    memcpy(slips, e->slips, e->bends * sizeof(real));
    if (core_move_checked(c, q, qd) || fill_transition(e, q, qd, e->last_tensions, h)) return 1;
    fill_jitter(e);
    memcpy(c->q, q, n * sizeof(real));
    memcpy(c->qd, qd, n * sizeof(real));
    if (core_step(c, e->last_tensions, e->load, h, 1)) return 1;
    memcpy(q, c->q, n * sizeof(real));
    memcpy(qd, c->qd, n * sizeof(real));
    memcpy(e->slips, slips, e->bends * sizeof(real));
    return 0;
}

int estimator_predict(estimator *e, real h)
{
    if (estimator_advance(e, h)) return 1;
    estimator_propagate(e, e->transition, e->covariance);
    estimator_add_noise(e, h, e->covariance);
    return 0;
}
