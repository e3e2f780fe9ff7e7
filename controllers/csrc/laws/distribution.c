/* The forces that produce the torque of a law, eq. (3):

     min 1/2 (f - f_p)'H (f - f_p)   s.t.   tau = -L'f,   f_min <= f <= f_max

   or another norm of H^1/2 (f - f_p). If this is infeasible, the forces minimise the error of the
   acceleration, |M^-1 (tau + L'f)|.

   Passive coordinates are not controlled: their accelerations result from the other coordinates. They are
   eliminated with their own rows, so that the remaining equations are exact: M, tau and L of the other
   coordinates become their Schur complements. */
#include "distribution.h"

#include "../../../sim_dart/csrc/math/cholesky.h"
#include "../../../sim_dart/csrc/optional_parts.h"
#include "law_choice.h"
#include "norm.h"
#include "program.h"

#include <math.h>
#include <string.h>

static const real TOLERANCE = PRECISE(1e-6, 1e-4); /* of a torque, relative to 1 + the maximum */
static const real SOFTNESS[2] = {PRECISE(1e-8, 1e-6), PRECISE(1e-6, 1e-4)}; /* relative to the rows */

/* The smallest softness that is a normal number. */
static const real MIN_SOFTNESS = PRECISE(2.3e-308, 1.2e-38);

static void fill(const computed_torque *s, dual_newton *program)
{
    real mean = 0;
    for (size_t i = 0; i < s->m; i++) mean += s->H_f[i] / (real)s->m;
    for (size_t i = 0; i < s->m; i++) {
        program->H_diagonal[i] = s->H_f[i] / mean; /* only ratios are relevant */
        program->g[i] = program->H_diagonal[i] * (0 - s->f_p[i]);
        program->lb[i] = s->f_min[i];
        program->ub[i] = s->f_max[i];
    }
}

static real allowed(const computed_torque *s)
{
    real maximum = 0;
    for (size_t j = 0; j < s->n; j++) maximum = larger(maximum, fabs(s->active_tau[j]));
    return (s->tolerance[0] > 0 ? s->tolerance[0] : TOLERANCE) * (1 + maximum);
}

/* Compute slack = tau + L'f. Return its maximum. */
static real compute_slack(computed_torque *s)
{
    real maximum = 0;
    memcpy(s->slack, s->active_tau, s->n * sizeof(real));
    for (size_t i = 0; i < s->m; i++) add(s->n, s->slack, s->forces[i], s->L + i * s->n);
    for (size_t j = 0; j < s->n; j++) maximum = larger(maximum, fabs(s->slack[j]));
    return maximum;
}

/* Compute forces and slack of a solution. Return the maximum slack. */
static real use_solution(computed_torque *s, const real *forces)
{
    for (size_t i = 0; i < s->m; i++) s->forces[i] = clip(forces[i], s->f_min[i], s->f_max[i]);
    return compute_slack(s);
}

/* Eliminate a passive coordinate from all other rows; its rows become those of a unit mass at rest. */
static void eliminate_passive(computed_torque *s, size_t p, real *tau)
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

/* Compute the torque without passive coordinates. Return 0, or COMPUTED_TORQUE_WRONG. */
static int compute_torque(computed_torque *s)
{
    if (!USES_NORMS && s->norm[0] != 0 && s->norm[0] != 2) return COMPUTED_TORQUE_WRONG;
    joint_law_torque(s);
    memcpy(s->active_tau, s->tau, s->n * sizeof(real));
    for (size_t j = 0; j < s->n; j++)
        if (s->passive[j] != 0) eliminate_passive(s, j, s->active_tau);
    for (size_t j = 0; j < s->n; j++)
        if (!isfinite(s->active_tau[j])) return COMPUTED_TORQUE_WRONG;
    return 0;
}

static void build_hard(computed_torque *s)
{
    fill(s, s->hard);
    for (size_t k = 0; k < s->m * s->n; k++) s->hard->A[k] = -s->L[k];
    memcpy(s->hard->b, s->active_tau, s->n * sizeof(real));
    memset(s->hard->softness, 0, s->n * sizeof(real));
    s->built = s->hard;
}

/* Return 0, or COMPUTED_TORQUE_WRONG. */
static int build_soft(computed_torque *s, real relative_softness)
{
    const size_t n = s->n, m = s->m;
    dual_newton *program = s->built = second_program(s, m);
    real size = 0, weights = 0;
    fill(s, program);
    if (cholesky_factor(n, s->M, s->factor)) return COMPUTED_TORQUE_WRONG;
    memcpy(program->b, s->active_tau, n * sizeof(real));
    cholesky_solve(n, s->factor, program->b);
    for (size_t i = 0; i < m; i++) {
        real *column = program->A + i * n;
        for (size_t j = 0; j < n; j++) column[j] = -s->L[i * n + j];
        cholesky_solve(n, s->factor, column);
        size += dot(n, column, column);
        weights += program->H_diagonal[i];
    }
    const real softness = larger(relative_softness * size / weights, MIN_SOFTNESS);
    for (size_t j = 0; j < n; j++) program->softness[j] = softness;
    return 0;
}

int distribution_build(computed_torque *s)
{
    const int wrong = compute_torque(s);
    build_hard(s);
    return wrong;
}

/* Continue from the feasible least-squares forces with another norm. */
static int finish(computed_torque *s)
{
    if (USES_NORMS && norm_minimize(s) != DUAL_NEWTON_SOLVED) return COMPUTED_TORQUE_NOT_CONVERGED;
    return compute_slack(s) <= allowed(s) ? COMPUTED_TORQUE_SOLVED : COMPUTED_TORQUE_NOT_CONVERGED;
}

int distribution_finish(computed_torque *s, const real *x)
{
    return use_solution(s, x) <= allowed(s) ? finish(s) : COMPUTED_TORQUE_FAILED;
}

static int solve_soft(computed_torque *s, int is_proven)
{
    int status = DUAL_NEWTON_NOT_CONVERGED;
    for (int attempt = 0; attempt < 2 && status != DUAL_NEWTON_SOLVED; attempt++) {
        if (build_soft(s, SOFTNESS[attempt])) return COMPUTED_TORQUE_WRONG;
        status = solve_from(s->built, s->memory + s->m + s->rows);
    }
    if (status != DUAL_NEWTON_SOLVED) return COMPUTED_TORQUE_FAILED;
    if (use_solution(s, s->built->x) <= allowed(s)) return COMPUTED_TORQUE_SOLVED;
    return is_proven ? COMPUTED_TORQUE_SOFT : COMPUTED_TORQUE_NOT_CONVERGED;
}

int distribution_solve(computed_torque *s)
{
    if (distribution_build(s)) return COMPUTED_TORQUE_WRONG;
    const int status = solve_from(s->hard, s->memory + s->m);
    if (status > DUAL_NEWTON_NOT_CONVERGED) return COMPUTED_TORQUE_WRONG;
    if (status == DUAL_NEWTON_SOLVED && use_solution(s, s->hard->x) <= allowed(s)) return finish(s);
    return solve_soft(s, status == DUAL_NEWTON_INFEASIBLE);
}
