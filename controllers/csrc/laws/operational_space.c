/* Computed torque in operational space, eq. (4):

     min  1/2 (qdd - qdd_p)'H_q (qdd - qdd_p) + 1/2 (f - f_p)'H_f (f - f_p) + 1/2 (f - f_last)'H_r (f - f_last)
          + 1/2 s'W s
     s.t. M qdd + h = -L'f,   J qdd + J' qd + s = ydd_d + Kd (yd_d - J qd) + Kp (y_d - y),
          f_min <= f <= f_max,   -2 w qd - w^2 (q - q_min) <= qdd <= -2 w qd + w^2 (q_max - q)

   over qdd, f and s, with qdd_p = kp (q0 - q) - kd qd. If this is infeasible, all tasks become soft, then
   the joint limits are dropped; the motion equation always holds.

   With several priorities, each program contains the tasks of its priority and of all earlier ones, whose J
   qdd is fixed to the result of the previous program. */
#include "operational_space.h"

#include "program.h"

#include <math.h>
#include <string.h>

/* Softness of tasks, relative to the scale of the program: first this value, then much more; finally, as the
   rows of earlier tasks may depend on each other and disagree by rounding errors, also a little for these. */
static const struct {
    real now, before;
} SOFTNESS[3] = {{1e-4, 0}, {1e-2, 0}, {1e-4, PRECISE(1e-10, 1e-6)}};

/* Tolerances of a row in a solution of another solver and of our solver if it has not converged, relative to
   the terms of the row. Rows with terms below a share of the largest row are compared with that share: a
   task at rest at its target consists of rounding errors only. */
static const real ACCEPTED = PRECISE(1e-6, 1e-4), NEAR = PRECISE(1e-9, 1e-5), MIN_ROW = PRECISE(1e-8, 1e-4);

/* Return whether the task has the priority of the program or an earlier one. Other tasks have empty rows. */
static int is_active_task(const computed_torque *s, size_t task)
{
    return s->priority[task] == s->rank;
}

static int is_known(const computed_torque *s, size_t task)
{
    return s->priority[task] <= s->rank;
}

static int has_before(const computed_torque *s)
{
    for (size_t i = 0; i < s->k; i++)
        if (s->priority[i] < s->rank) return 1;
    return 0;
}

/* Return the minimum priority above a number; infinite if there are no further priorities. */
static real next_rank(const computed_torque *s, real rank)
{
    real next = INFINITY;
    for (size_t i = 0; i < s->k; i++)
        if (s->priority[i] > rank) next = smaller(next, s->priority[i]);
    return next;
}

static int has_limits(const computed_torque *s)
{
    return s->limit_bandwidth[0] > 0;
}

/* Set the costs, the bounds of f and the rows. Variables are qdd and then f. */
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
        for (size_t i = 0; i < k; i++) column[n + i] = is_known(s, i) ? s->J[i * n + j] : 0;
        program->b[j] = -(s->h[j] + s->load[j]);
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
    for (size_t i = 0; i < k; i++) program->b[n + i] = is_known(s, i) ? s->target[i] : 0;
}

static void bound_accelerations(const computed_torque *s, dual_newton *program)
{
    const real w = s->limited ? s->limit_bandwidth[0] : 0;
    for (size_t j = 0; j < s->n; j++) {
        const real brake = -2 * w * s->qd[j];
        program->lb[j] = w > 0 ? brake - w * w * (s->q[j] - s->q_min[j]) : -INFINITY;
        program->ub[j] = w > 0 ? brake + w * w * (s->q_max[j] - s->q[j]) : INFINITY;
    }
}

/* Return the softness of the row of a task, from its weight. */
static real task_softness(const computed_torque *s, size_t task)
{
    return is_active_task(s, task) && isfinite(s->W[task]) ? 1 / s->W[task] : 0;
}

static void build_hard(computed_torque *s)
{
    s->built = s->hard;
    fill(s, s->hard);
    bound_accelerations(s, s->hard);
    for (size_t i = 0; i < s->k; i++) s->hard->softness[s->n + i] = task_softness(s, i);
}

/* Make all tasks of the priority soft: those of finite weight keep at least their own softness. */
static void build_soft(computed_torque *s, int attempt)
{
    dual_newton *program = s->built = second_program(s, s->n + s->m);
    real scale = 0, count = 0;
    fill(s, program);
    bound_accelerations(s, program);
    for (size_t i = 0; i < s->k; i++) count += is_active_task(s, i);
    for (size_t i = 0; i < s->n + s->m; i++)
        for (size_t j = 0; j < s->k; j++) {
            const real a = is_active_task(s, j) ? program->A[i * s->rows + s->n + j] : 0;
            scale += a * a / program->H_diagonal[i] / count;
        }
    if (!(scale > 0)) scale = 1;
    const real now = SOFTNESS[attempt].now * scale, before = SOFTNESS[attempt].before * scale;
    for (size_t i = 0; i < s->k; i++)
        program->softness[s->n + i] = is_active_task(s, i) ? larger(task_softness(s, i), now) : before;
}

static int all_weighted(const computed_torque *s)
{
    for (size_t i = 0; i < s->k; i++)
        if (is_active_task(s, i) && !isfinite(s->W[i])) return 0;
    return 1;
}

/* Return 0, or COMPUTED_TORQUE_WRONG. */
static int begin(computed_torque *s)
{
    desired_acceleration(s, s->desired);
    for (size_t i = 0; i < s->k; i++) {
        s->target[i] = s->desired[i] -= s->bias[i];
        if (!isfinite(s->desired[i])) return COMPUTED_TORQUE_WRONG;
    }
    s->rank = next_rank(s, -INFINITY);
    s->limited = has_limits(s);
    s->worst = COMPUTED_TORQUE_SOLVED;
    return 0;
}

/* Use qdd and f of a priority, and continue with the next one, or finish. */
static int use_solution(computed_torque *s, const real *x, int status)
{
    const size_t n = s->n;
    const real next = next_rank(s, s->rank);
    memcpy(s->qdd, x, n * sizeof(real));
    s->worst = status > s->worst ? status : s->worst;
    if (isfinite(next)) {
        for (size_t i = 0; i < s->k; i++)
            if (is_active_task(s, i)) s->target[i] = dot(n, s->J + i * n, x);
        s->rank = next;
        return COMPUTED_TORQUE_NEXT;
    }
    for (size_t i = 0; i < s->m; i++) s->forces[i] = clip(x[n + i], s->f_min[i], s->f_max[i]);
    for (size_t i = 0; i < s->k; i++) s->slack[i] = s->desired[i] - dot(n, s->J + i * n, x);
    s->limits_dropped[0] = has_limits(s) && !s->limited;
    return s->worst;
}

/* Return whether x satisfies the hard rows and the bounds of the program; rows have length 1 if H is 1. */
static int satisfies_rows(dual_newton *program, const real *x, real tolerance)
{
    const size_t rows = program->m;
    real *rest = program->r, *size = program->size, *length = program->rest, largest = 0;
    for (size_t j = 0; j < rows; j++) rest[j] = -program->b[j], size[j] = fabs(program->b[j]), length[j] = 0;
    for (size_t i = 0; i < program->n; i++) {
        const real low = program->lb[i], high = program->ub[i], margin = tolerance * (1 + fabs(x[i]));
        if (!(x[i] >= low - margin && x[i] <= high + margin)) return 0;
        for (size_t j = 0; j < rows; j++) {
            const real a = program->A[i * rows + j], term = a * clip(x[i], low, high);
            rest[j] += term, size[j] += fabs(term), length[j] += a * a / program->H_diagonal[i];
        }
    }
    for (size_t j = 0; j < rows; j++) {
        length[j] = length[j] > 0 ? sqrt(length[j]) : 1;
        largest = larger(largest, size[j] / length[j]);
    }
    for (size_t j = 0; j < rows; j++)
        if (program->softness[j] == 0 &&
            !(fabs(rest[j]) <= tolerance * (size[j] + MIN_ROW * largest * length[j])))
            return 0;
    return 1;
}

/* Solve a program, and accept residuals due to rounding errors. Return the status. */
static int solve_approximately(dual_newton *program, real *start)
{
    const int status = solve_from(program, start);
    const int is_near = status == DUAL_NEWTON_NOT_CONVERGED && program->residuals[1] <= NEAR;
    return is_near && satisfies_rows(program, program->x, NEAR) ? DUAL_NEWTON_SOLVED : status;
}

/* Solve the program of the priority; if it is infeasible, make the tasks soft, then drop the joint limits. */
static int solve_priority(computed_torque *s)
{
    real *hard = s->memory + s->m, *soft = hard + s->rows;
    int otherwise = COMPUTED_TORQUE_SOFT; /* while every program before is proven infeasible */
    const int first = s->limited;
    for (; s->limited >= 0; s->limited--) {
        build_hard(s);
        int status = solve_approximately(s->hard, hard);
        if (status > DUAL_NEWTON_NOT_CONVERGED) return COMPUTED_TORQUE_WRONG;
        if (status == DUAL_NEWTON_SOLVED)
            return use_solution(s, s->hard->x, s->limited == first ? COMPUTED_TORQUE_SOLVED : otherwise);
        if (status == DUAL_NEWTON_NOT_CONVERGED) otherwise = COMPUTED_TORQUE_NOT_CONVERGED;
        if (all_weighted(s) && status == DUAL_NEWTON_INFEASIBLE) continue;
        for (int attempt = 0; attempt < 2 + has_before(s); attempt++) {
            build_soft(s, attempt);
            status = solve_from(s->built, soft);
            if (status == DUAL_NEWTON_SOLVED) return use_solution(s, s->built->x, otherwise);
            if (status == DUAL_NEWTON_INFEASIBLE && attempt == 0) attempt = 1; /* more softness is useless */
        }
        if (status == DUAL_NEWTON_NOT_CONVERGED) otherwise = COMPUTED_TORQUE_NOT_CONVERGED;
    }
    /* These forces satisfy the motion equation, but the minimum error is not proven. */
    s->limited = 0;
    return satisfies_rows(s->built, s->built->x, ACCEPTED) ? use_solution(s, s->built->x, COMPUTED_TORQUE_NOT_CONVERGED)
                                                 : COMPUTED_TORQUE_FAILED;
}

int operational_space_build(computed_torque *s)
{
    if (begin(s)) return COMPUTED_TORQUE_WRONG;
    build_hard(s);
    return COMPUTED_TORQUE_SOLVED;
}

int operational_space_finish(computed_torque *s, const real *x)
{
    if (!satisfies_rows(s->built, x, ACCEPTED)) return COMPUTED_TORQUE_FAILED;
    const int status = use_solution(s, x, COMPUTED_TORQUE_SOLVED);
    if (status == COMPUTED_TORQUE_NEXT) build_hard(s);
    return status;
}

int operational_space_solve(computed_torque *s)
{
    int status = begin(s) ? COMPUTED_TORQUE_WRONG : COMPUTED_TORQUE_NEXT;
    while (status == COMPUTED_TORQUE_NEXT) status = solve_priority(s);
    return status;
}
