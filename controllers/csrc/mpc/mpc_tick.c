/* A tick of model predictive control. */
#include "mpc.h"

#include "costs.h"
#include "errors.h"
#include "planned_motion.h"

#include <string.h>

enum { FIRST_STEPS = 4 }; /* programs from a robot at rest, at the first tick */
static const real UNLIMITED = PRECISE(1e30, 1e20f); /* forces above it are not bounds */
static const real REST = 1e-4; /* of the linearized dynamics, which the next tick corrects */

/* Simulate the planned motion, for C and c of the program. Return nonzero if it diverged. */
static int linearize(mpc *s, const real *load)
{
    const size_t n = 2 * s->n;
    if (s->model.intervals(s->model.self, s->h, s->x, s->f, load, s->ends, s->qp.C)) return 1;
    for (size_t i = 0; i < s->N * n; i++) s->qp.c[i] = s->ends[i] - s->x[n + i];
    return 0;
}

/* Set the bounds of the changes of forces. A force with one possible value does not change. */
static void bound_forces(mpc *s, size_t k)
{
    const size_t n = 2 * s->n, a = s->a, w = a + n;
    const real *low = k ? s->f_min : s->first_min, *high = k ? s->f_max : s->first_max;
    real *f = s->f + k * a, *C = s->qp.C + k * n * w;
    for (size_t i = 0; i < a; i++) {
        const int is_fixed = !(high[i] > low[i]);
        if (is_fixed) f[i] = low[i];
        s->qp.low[k * w + i] = is_fixed || low[i] < -UNLIMITED ? -INFINITY : low[i] - f[i];
        s->qp.high[k * w + i] = is_fixed || high[i] > UNLIMITED ? INFINITY : high[i] - f[i];
        for (size_t l = 0; is_fixed && l < n; l++) C[l * w + i] = 0;
    }
}

static void bound_states(mpc *s, size_t k)
{
    const size_t n = s->n, at = mpc_states(s, k);
    const real *q = s->x + k * 2 * n, *qd = q + n;
    real *low = s->qp.low + at, *high = s->qp.high + at, *penalty = s->qp.penalty + at;
    for (size_t j = 0; j < n; j++) {
        low[j] = s->q_min[j] - q[j], high[j] = s->q_max[j] - q[j];
        low[n + j] = -s->qd_max[j] - qd[j], high[n + j] = s->qd_max[j] - qd[j];
        penalty[j] = penalty[n + j] = mpc_share(s, k) * s->limit_penalty[j];
    }
}

static int has_deadline(const mpc *s)
{
    return s->model.clock && s->deadline[0] > 0;
}

static void start_clock(mpc *s)
{
    s->is_late[0] = 0;
    if (has_deadline(s)) s->begun = s->looked = s->model.clock(s->model.self);
    s->longest = 0;
}

/* Return whether another iteration would probably end after the deadline: it takes as long as the longest one
   of the tick. */
static int is_late(mpc *s)
{
    if (!has_deadline(s)) return 0;
    const double now = s->model.clock(s->model.self), last = now - s->looked;
    if (stage_qp_iterations(s->program) > 0 && last > s->longest) s->longest = last;
    s->looked = now;
    s->is_late[0] = now - s->begun + s->longest > (double)s->deadline[0];
    return s->is_late[0] != 0;
}

/* Note whether the tick took longer than its deadline, although it used the solution. */
static void note_overrun(mpc *s)
{
    if (has_deadline(s) && s->model.clock(s->model.self) - s->begun > (double)s->deadline[0]) s->is_late[0] = 1;
}

/* Solve the program, from no change, while the tick has at most `most` iterations. Return an enum
   stage_qp_status. */
static int solve_program(mpc *s, real most)
{
    memset(s->qp.v, 0, (s->N * (s->a + 2 * s->n) + 2 * s->n) * sizeof(real));
    s->qp.tolerance[0] = s->tolerance[0], s->qp.tolerance[1] = REST;
    int status = stage_qp_begin(s->program);
    for (; status == STAGE_QP_NOT_CONVERGED && s->used[0] < most && !is_late(s); s->used[0]++)
        status = stage_qp_iterate(s->program);
    return status;
}

/* Compute one step of the motion. Return nonzero without a solution. */
static int improve(mpc *s, real most, const real *now, const real *correction, const real *load)
{
    planned_motion_clip(s);
    if (linearize(s, load)) return 1;
    mpc_compute_errors(s, now);
    for (size_t k = 0; k < s->N; k++) bound_forces(s, k);
    for (size_t k = 1; k <= s->N; k++) bound_states(s, k);
    mpc_set_costs(s, correction);
    if (solve_program(s, most) != STAGE_QP_SOLVED) return 1;
    planned_motion_add(s);
    return 0;
}

int mpc_solve(void *self, const real *q, const real *qd, const real *reference, const real *correction,
              const real *load, real *forces, real *slack)
{
    mpc *s = self;
    const size_t n = s->n, a = s->a;
    const int is_first = s->planned[0] == 0, steps = is_first ? FIRST_STEPS : 1;
    start_clock(s);
    planned_motion_divide(s);
    if (is_first) planned_motion_rest(s, q);
    memcpy(s->before, s->f, a * sizeof(real));
    if (!is_first) planned_motion_shift(s);
    memcpy(s->x, q, n * sizeof(real));
    memcpy(s->x + n, qd, n * sizeof(real));
    s->planned[0] = 0;
    s->used[0] = 0;
    for (int step = 0; step < steps; step++)
        if (improve(s, (real)steps * s->iterations[0], reference, correction, load)) {
            s->planned[0] = s->is_late[0] != 0 && (!is_first || step > 0);
            return COMPUTED_TORQUE_NEXT;
        }
    s->planned[0] = 1;
    for (size_t i = 0; i < a; i++) forces[i] = clip(s->f[i], s->first_min[i], s->first_max[i]);
    memset(slack, 0, s->r * sizeof(real));
    note_overrun(s);
    return COMPUTED_TORQUE_SOLVED;
}
