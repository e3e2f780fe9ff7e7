/* Computed torque in joint space, eq. (3):

     min 1/2 (f - f_p)'H (f - f_p)   s.t.   M(qdd_d + Kd (qd_d - qd) + Kp (q_d - q)) + h = -L'f,   f_min <= f <= f_max

   or another norm of H^1/2 (f - f_p), and where no force fits, the forces whose acceleration errs least: |M^-1 (tau + L'f)|.

   Passive coordinates follow nothing: their accelerations are whatever the others make of them. They are
   eliminated by their own rows, so that the rest is exact: M, tau and L of the others become their Schur
   complements.                                                                                         */
#include "joint_space.h"

#include "../../../sim_dart/csrc/math/cholesky.h"
#include "norm.h"
#include "program.h"

#include <math.h>
#include <string.h>

static const real TOLERANCE = PRECISE(1e-6, 1e-4); /* of a torque, relative to 1 + the largest */
static const real SOFTNESS[2] = {PRECISE(1e-8, 1e-6), PRECISE(1e-6, 1e-4)}; /* relative to the rows' size */

static void fill(const computed_torque *s, dual_newton *program)
{
    real mean = 0;
    for (size_t i = 0; i < s->m; i++) mean += s->H_f[i] / (real)s->m;
    for (size_t i = 0; i < s->m; i++) {
        program->H_diagonal[i] = s->H_f[i] / mean; /* only ratios matter */
        program->g[i] = program->H_diagonal[i] * (0 - s->f_p[i]);
        program->lb[i] = s->f_min[i];
        program->ub[i] = s->f_max[i];
    }
}

/* slack = tau + L'f; its largest entry. */
static real missing(computed_torque *s, const real *tau)
{
    real most = 0;
    memcpy(s->slack, tau, s->n * sizeof(real));
    for (size_t i = 0; i < s->m; i++) add(s->n, s->slack, s->forces[i], s->L + i * s->n);
    for (size_t j = 0; j < s->n; j++) most = larger(most, fabs(s->slack[j]));
    return most;
}

/* Forces and slack of an answer; the largest slack. */
static real take(computed_torque *s, const real *tau, const real *forces)
{
    memcpy(s->forces, forces, s->m * sizeof(real));
    return missing(s, tau);
}

/* The smallest softness that is a normal number. */
static const real LEAST_SOFTNESS = PRECISE(2.3e-308, 1.2e-38);

static int solve_soft(computed_torque *s, const real *tau, real allowed, int is_proven)
{
    const size_t n = s->n, m = s->m;
    dual_newton *program = s->soft;
    real size = 0, weights = 0;
    fill(s, program);
    if (cholesky_factor(n, s->M, s->factor)) return COMPUTED_TORQUE_WRONG;
    memcpy(program->b, tau, n * sizeof(real));
    cholesky_solve(n, s->factor, program->b);
    for (size_t i = 0; i < m; i++) {
        real *column = program->A + i * n;
        for (size_t j = 0; j < n; j++) column[j] = -s->L[i * n + j];
        cholesky_solve(n, s->factor, column);
        size += dot(n, column, column);
        weights += program->H_diagonal[i];
    }
    int status = DUAL_NEWTON_NOT_CONVERGED;
    for (int attempt = 0; attempt < 2 && status != DUAL_NEWTON_SOLVED; attempt++) {
        const real softness = larger(SOFTNESS[attempt] * size / weights, LEAST_SOFTNESS);
        for (size_t j = 0; j < n; j++) program->softness[j] = softness;
        status = solve_from(program, s->memory + m + s->rows);
    }
    if (status != DUAL_NEWTON_SOLVED) return COMPUTED_TORQUE_FAILED;
    if (take(s, tau, program->x) <= allowed) return COMPUTED_TORQUE_SOLVED;
    return is_proven ? COMPUTED_TORQUE_SOFT : COMPUTED_TORQUE_NOT_CONVERGED;
}

/* Take a passive coordinate out of all other rows; its own become those of a unit mass at rest. */
static void eliminate(computed_torque *s, size_t p, real *tau)
{
    const size_t n = s->n, m = s->m;
    const real pivot = s->M[p * n + p];
    for (size_t j = 0; j < n; j++) {
        if (j == p) continue;
        const real factor = s->M[j * n + p] / pivot;
        for (size_t k = 0; k < n; k++)
            if (k != p) s->M[j * n + k] -= factor * s->M[p * n + k];
        for (size_t i = 0; i < m; i++) s->L[i * n + j] -= factor * s->L[i * n + p];
        tau[j] -= factor * tau[p];
    }
    for (size_t j = 0; j < n; j++) s->M[j * n + p] = s->M[p * n + j] = j == p;
    for (size_t i = 0; i < m; i++) s->L[i * n + p] = 0;
    tau[p] = 0;
}

int joint_space_solve(computed_torque *s)
{
    const size_t n = s->n, m = s->m;
    dual_newton *program = s->hard;
    real *tau = s->column, most = 0;
    desired_acceleration(s, s->desired);
    for (size_t j = 0; j < n; j++) tau[j] = dot(n, s->M + j * n, s->desired) + s->h[j];
    for (size_t j = 0; j < n; j++)
        if (s->passive[j] != 0) eliminate(s, j, tau);
    for (size_t j = 0; j < n; j++) {
        if (!isfinite(tau[j])) return COMPUTED_TORQUE_WRONG;
        most = larger(most, fabs(tau[j]));
    }
    const real allowed = TOLERANCE * (1 + most);
    fill(s, program);
    for (size_t k = 0; k < m * n; k++) program->A[k] = -s->L[k];
    memcpy(program->b, tau, n * sizeof(real));
    const int status = solve_from(program, s->memory + m);
    if (status > DUAL_NEWTON_NOT_CONVERGED) return COMPUTED_TORQUE_WRONG;
    if (status == DUAL_NEWTON_SOLVED && take(s, tau, program->x) <= allowed) {
        if (norm_least(s) != DUAL_NEWTON_SOLVED) return COMPUTED_TORQUE_NOT_CONVERGED;
        return missing(s, tau) <= allowed ? COMPUTED_TORQUE_SOLVED : COMPUTED_TORQUE_NOT_CONVERGED;
    }
    return solve_soft(s, tau, allowed, status == DUAL_NEWTON_INFEASIBLE);
}
