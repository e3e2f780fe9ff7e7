/* Computed torque in operational space, eq. (4):

     min  1/2 (qdd - qdd_p)'H_q (qdd - qdd_p) + 1/2 (f - f_p)'H_f (f - f_p) + 1/2 (f - f_last)'H_r (f - f_last)
          + 1/2 s'W s
     s.t. M qdd + h = -L'f,   J qdd + J' qd + s = ydd_d + Kd (yd_d - J qd) + Kp (y_d - y),
          f_min <= f <= f_max,   -2 w qd - w^2 (q - q_min) <= qdd <= -2 w qd + w^2 (q_max - q)

   over qdd, f and s, with qdd_p = kp (q0 - q) - kd qd. Where that has no solution all tasks give way, then
   the limits of the joints; the motion equation never does.                                           */
#include "operational_space.h"

#include "program.h"

#include <math.h>
#include <string.h>

/* Of tasks that give way, relative to the program's scale: first that, then much more. */
static const real SOFTNESS[2] = {1e-4, 1e-2};

/* Costs, bounds and rows but for the limits on qdd. Variables are qdd and then f. */
static void fill(const computed_torque *s, dual_newton *program)
{
    const size_t n = s->n, m = s->m, k = s->k, rows = s->rows;
    const real *f_last = s->memory;
    for (size_t j = 0; j < n; j++) {
        const real posture = s->posture_kp[j] * (s->q0[j] - s->q[j]) - s->posture_kd[j] * s->qd[j];
        real *column = program->A + j * rows;
        program->H_diagonal[j] = s->H_q[j];
        program->g[j] = -s->H_q[j] * posture;
        for (size_t i = 0; i < n; i++) column[i] = s->M[i * n + j];
        for (size_t i = 0; i < k; i++) column[n + i] = s->J[i * n + j];
        program->b[j] = -s->h[j];
    }
    for (size_t i = 0; i < m; i++) {
        real *column = program->A + (n + i) * rows;
        program->H_diagonal[n + i] = s->H_f[i] + s->H_r[i];
        program->g[n + i] = -s->H_f[i] * s->f_p[i] - s->H_r[i] * f_last[i];
        program->lb[n + i] = s->f_min[i];
        program->ub[n + i] = s->f_max[i];
        memcpy(column, s->L + i * n, n * sizeof(real));
        memset(column + n, 0, k * sizeof(real));
    }
    memcpy(program->b + n, s->desired, k * sizeof(real));
}

static void bound_accelerations(const computed_torque *s, dual_newton *program, real w)
{
    for (size_t j = 0; j < s->n; j++) {
        const real brake = -2 * w * s->qd[j];
        program->lb[j] = w > 0 ? brake - w * w * (s->q[j] - s->q_min[j]) : -INFINITY;
        program->ub[j] = w > 0 ? brake + w * w * (s->q_max[j] - s->q[j]) : INFINITY;
    }
}

/* A task of a finite weight is a row that may give way. */
static void weigh_tasks(const computed_torque *s, dual_newton *program)
{
    for (size_t i = 0; i < s->k; i++) program->softness[s->n + i] = isfinite(s->W[i]) ? 1 / s->W[i] : 0;
}

/* All tasks give way, those of a finite weight at least as much as that says. */
static void soften_tasks(const computed_torque *s, dual_newton *program, real softness)
{
    real scale = 0;
    for (size_t i = 0; i < s->n + s->m; i++)
        for (size_t j = s->n; j < s->rows; j++) {
            const real a = program->A[i * s->rows + j];
            scale += a * a / program->H_diagonal[i] / (real)s->k;
        }
    if (!(scale > 0)) scale = 1;
    for (size_t i = 0; i < s->k; i++) {
        const real own = isfinite(s->W[i]) ? 1 / s->W[i] : 0;
        program->softness[s->n + i] = larger(own, softness * scale);
    }
}

static int all_weighted(const computed_torque *s)
{
    for (size_t i = 0; i < s->k; i++)
        if (!isfinite(s->W[i])) return 0;
    return 1;
}

static int answer(computed_torque *s, const dual_newton *program, int limited, int status)
{
    const real *qdd = program->x;
    memcpy(s->forces, program->x + s->n, s->m * sizeof(real));
    for (size_t i = 0; i < s->k; i++) s->slack[i] = s->desired[i] - dot(s->n, s->J + i * s->n, qdd);
    const int dropped = s->limit_bandwidth[0] > 0 && !limited;
    s->limits_dropped[0] = dropped;
    return status;
}

int operational_space_solve(computed_torque *s)
{
    real *hard = s->memory + s->m, *soft = hard + s->rows;
    desired_acceleration(s, s->desired);
    for (size_t i = 0; i < s->k; i++) {
        s->desired[i] -= s->bias[i];
        if (!isfinite(s->desired[i])) return COMPUTED_TORQUE_WRONG;
    }
    fill(s, s->hard);
    fill(s, s->soft);
    weigh_tasks(s, s->hard);
    int otherwise = COMPUTED_TORQUE_SOFT; /* while every program before is proven infeasible */
    for (int limited = s->limit_bandwidth[0] > 0; limited >= 0; limited--) {
        const real w = limited ? s->limit_bandwidth[0] : 0;
        bound_accelerations(s, s->hard, w);
        int status = solve_from(s->hard, hard);
        if (status > DUAL_NEWTON_NOT_CONVERGED) return COMPUTED_TORQUE_WRONG;
        if (status == DUAL_NEWTON_SOLVED) {
            const int dropped = s->limit_bandwidth[0] > 0 && !limited;
            return answer(s, s->hard, limited, dropped ? otherwise : COMPUTED_TORQUE_SOLVED);
        }
        if (status == DUAL_NEWTON_NOT_CONVERGED) otherwise = COMPUTED_TORQUE_NOT_CONVERGED;
        if (all_weighted(s)) continue;
        bound_accelerations(s, s->soft, w);
        for (int attempt = 0; attempt < 2; attempt++) {
            soften_tasks(s, s->soft, SOFTNESS[attempt]);
            status = solve_from(s->soft, soft);
            if (status == DUAL_NEWTON_SOLVED) return answer(s, s->soft, limited, otherwise);
            if (status == DUAL_NEWTON_INFEASIBLE) break; /* the motion equation itself */
        }
        if (status == DUAL_NEWTON_NOT_CONVERGED) otherwise = COMPUTED_TORQUE_NOT_CONVERGED;
    }
    return COMPUTED_TORQUE_FAILED;
}
