#include "errors.h"

#include "../../../sim_dart/csrc/math/cholesky.h"

static const real TINY = 1e-6; /* makes singular tasks regular */

/* Compute P = I - J' (J J' + tiny)^-1 J. */
static void project(mpc *s, const real *J, real *P)
{
    const size_t n = s->n, r = s->r;
    real *factor = s->JJ + r * r, *column = s->bias;
    real trace = 0;
    for (size_t i = 0; i < r; i++) trace += dot(n, J + i * n, J + i * n);
    for (size_t i = 0; i < r; i++)
        for (size_t j = 0; j < r; j++)
            s->JJ[i * r + j] = dot(n, J + i * n, J + j * n) + (i == j ? TINY * trace + TINY : 0);
    cholesky_factor(r, s->JJ, factor);
    for (size_t l = 0; l < n; l++) {
        for (size_t i = 0; i < r; i++) column[i] = J[i * n + l];
        cholesky_solve(r, factor, column);
        for (size_t j = 0; j < n; j++) {
            P[j * n + l] = j == l;
            for (size_t i = 0; i < r; i++) P[j * n + l] -= J[i * n + j] * column[i];
        }
    }
}

/* Compute the errors of node k for the current reference. */
static void errors_at(mpc *s, size_t k)
{
    const size_t n = s->n, r = s->r;
    const real *q = s->x + k * 2 * n, *qd = q + n, *velocity = s->reference + r;
    real *error = s->error + k * r, *rate = s->rate + k * r, *J = s->J + k * r * n;
    if (s->has_tasks) {
        s->model.tasks(s->model.self, q, qd, s->reference, error, J, s->bias);
        project(s, J, s->null + k * n * n);
    }
    for (size_t i = 0; i < r; i++) {
        if (!s->has_tasks) J[i * n + i] = 1;
        error[i] = s->has_tasks ? -error[i] : q[i] - s->reference[i];
        rate[i] = dot(n, J + i * n, qd) - velocity[i];
    }
}

void mpc_compute_errors(mpc *s, const real *now)
{
    real ahead = 0;
    for (size_t k = 0; k <= s->N; k++) {
        s->model.preview(s->model.self, ahead, now, s->reference);
        errors_at(s, k);
        if (k < s->N) ahead += s->h[k];
    }
}
