#include "mpc.h"

#include "../../../sim_dart/csrc/math/cholesky.h"
#include "../qp/vectors.h"

#include <string.h>

/* ARRAY(name, number of elements): first those of mpc_array. */
#define MPC_ARRAYS(ARRAY)                                                                              \
    ARRAY(horizon, 1)                                                                                  \
    ARRAY(period, 1)                                                                                   \
    ARRAY(iterations, 1)                                                                               \
    ARRAY(tolerance, 1)                                                                                \
    ARRAY(tracking, r)                                                                                 \
    ARRAY(tracking_rates, r)                                                                           \
    ARRAY(accelerations, r)                                                                            \
    ARRAY(posture, n)                                                                                  \
    ARRAY(posture_rates, n)                                                                            \
    ARRAY(posture_accelerations, n)                                                                    \
    ARRAY(q0, n)                                                                                       \
    ARRAY(speeds, n)                                                                                   \
    ARRAY(forces_cost, a)                                                                              \
    ARRAY(force_rates, a)                                                                              \
    ARRAY(f_p, a)                                                                                      \
    ARRAY(f_min, a)                                                                                    \
    ARRAY(f_max, a)                                                                                    \
    ARRAY(first_min, a)                                                                                \
    ARRAY(first_max, a)                                                                                \
    ARRAY(q_min, n)                                                                                    \
    ARRAY(q_max, n)                                                                                    \
    ARRAY(qd_max, n)                                                                                   \
    ARRAY(limit_penalty, n)                                                                            \
    ARRAY(used, 1)                                                                                     \
    ARRAY(planned, 1)          /* then x and f */                                                      \
    ARRAY(x, (N + 1) * 2 * n)                                                                          \
    ARRAY(f, N *a)                                                                                     \
    ARRAY(before, a)           /* the forces of the last tick */                                        \
    ARRAY(h, N)                /* lengths of the intervals */                                          \
    ARRAY(ends, N * 2 * n)                                                                             \
    ARRAY(error, (N + 1) * r)  /* position minus reference at the nodes, and its rate */               \
    ARRAY(rate, (N + 1) * r)                                                                           \
    ARRAY(J, (N + 1) * r * n)  /* of the followed coordinates */                                       \
    ARRAY(null, (N + 1) * n * n) /* projections on motions without motion of the tasks, symmetric */    \
    ARRAY(JJ, 2 * r *r)                                                                                 \
    ARRAY(bias, r)                                                                                     \
    ARRAY(reference, 3 * r)                                                                            \
    ARRAY(row, a + 2 * n)

#define MPC_MEMBER(name, length) real *name;
#define QP_MEMBER(name) real *name;
#define QP_ARRAYS(ARRAY)                                                                               \
    ARRAY(H) ARRAY(g) ARRAY(C) ARRAY(c) ARRAY(low) ARRAY(high) ARRAY(penalty) ARRAY(tolerance) ARRAY(v)
struct mpc {
    mpc_model model;
    size_t n, a, r, N;
    int has_tasks;
    stage_qp *program;
    struct {
        QP_ARRAYS(QP_MEMBER)
    } qp;
    MPC_ARRAYS(MPC_MEMBER)
};
#undef MPC_MEMBER
#undef QP_MEMBER

enum { FIRST_STEPS = 4 }; /* iterations from a robot at rest, at the first tick */
static const real UNLIMITED = PRECISE(1e30, 1e20f); /* forces above it are not bounds */
static const real TINY = 1e-6; /* makes singular tasks regular */
static const real REST = 1e-4; /* of the linearized dynamics, which the next tick corrects */

static size_t padded(size_t size)
{
    return (size + 7u) & ~(size_t)7u;
}

size_t mpc_size(int coordinates, int actuators, int tasks, int nodes)
{
    const size_t program = stage_qp_size(nodes, 2 * coordinates, actuators);
    if (!program || tasks < 0 || tasks > 512) return 0;
    const size_t n = (size_t)coordinates, a = (size_t)actuators, r = tasks ? (size_t)tasks : n, N = (size_t)nodes;
    size_t count = 0;
#define ADD_LENGTH(name, length) count += length;
    MPC_ARRAYS(ADD_LENGTH)
#undef ADD_LENGTH
    return padded(sizeof(mpc)) + padded(count * sizeof(real)) + program;
}

mpc *mpc_open(const mpc_model *model, int coordinates, int actuators, int tasks, int nodes, void *memory)
{
    const size_t size = mpc_size(coordinates, actuators, tasks, nodes);
    if (!size || !memory || (uintptr_t)memory % 8) return NULL;
    memset(memory, 0, size);
    mpc *s = memory;
    s->model = *model;
    const size_t n = s->n = (size_t)coordinates, a = s->a = (size_t)actuators, N = s->N = (size_t)nodes;
    const size_t r = s->r = tasks ? (size_t)tasks : n;
    s->has_tasks = tasks != 0;
    real *at = (real *)(void *)((char *)memory + padded(sizeof *s));
#define PLACE(name, length) s->name = at, at += length;
    MPC_ARRAYS(PLACE)
#undef PLACE
    void *rest = (char *)memory + (size - stage_qp_size(nodes, 2 * coordinates, actuators));
    s->program = stage_qp_open(nodes, 2 * coordinates, actuators, rest);
    size_t length;
#define FIND(name) s->qp.name = stage_qp_array(s->program, #name, &length);
    QP_ARRAYS(FIND)
#undef FIND
    return s;
}

real *mpc_array(mpc *s, const char *name, size_t *length)
{
    const size_t n = s->n, a = s->a, r = s->r, N = s->N;
    if (!strcmp(name, "planned")) return *length = 1 + (N + 1) * 2 * n + N * a, s->planned;
#define FIND(name_, length_) \
    if (!strcmp(name, #name_)) return *length = length_, s->name_;
    MPC_ARRAYS(FIND)
#undef FIND
    return NULL;
}

void mpc_reset(mpc *s)
{
    s->planned[0] = 0;
}

/* ----------------------------------------------------------------------------------- the last motion */

/* Set the lengths of the intervals. */
static void divide(mpc *s)
{
    const real h = (s->horizon[0] - s->period[0]) / (real)(s->N - 1);
    for (size_t k = 0; k < s->N; k++) s->h[k] = k ? h : s->period[0];
}

/* Shift the last motion by a period, between its nodes. */
static void shift(mpc *s)
{
    const size_t n = 2 * s->n, a = s->a, N = s->N;
    for (size_t k = 0; k < N; k++) {
        const real part = smaller(s->h[0] / s->h[k], 1);
        real *x = s->x + k * n, *f = s->f + k * a;
        for (size_t j = 0; j < n; j++) x[j] += part * (x[n + j] - x[j]);
        for (size_t i = 0; i < a && k + 1 < N; i++) f[i] += part * (f[a + i] - f[i]);
    }
    for (size_t j = 0; j < s->n; j++) s->x[N * n + j] += s->h[0] * s->x[N * n + s->n + j];
}

/* Start with a robot at rest and the preferred forces. */
static void rest(mpc *s, const real *q)
{
    for (size_t k = 0; k <= s->N; k++) {
        memcpy(s->x + k * 2 * s->n, q, s->n * sizeof(real));
        memset(s->x + (k * 2 + 1) * s->n, 0, s->n * sizeof(real));
    }
    for (size_t k = 0; k < s->N; k++) memcpy(s->f + k * s->a, s->f_p, s->a * sizeof(real));
}

/* ------------------------------------------------------------------------------------------ the program */

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

/* Compute errors of the motion, and their Jacobians. */
static void compare(mpc *s, const real *now)
{
    const size_t n = s->n, r = s->r;
    real ahead = 0;
    for (size_t k = 0; k <= s->N; ahead += k < s->N ? s->h[k] : 0, k++) {
        const real *q = s->x + k * 2 * n, *qd = q + n, *velocity = s->reference + r;
        real *error = s->error + k * r, *rate = s->rate + k * r, *J = s->J + k * r * n;
        s->model.preview(s->model.self, ahead, now, s->reference);
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
}

/* Add the cost weight (value + row v)^2 to a stage of n variables. */
static void add_square(mpc *s, size_t stage, size_t n, real weight, real value, const real *row)
{
    const size_t w = s->a + 2 * s->n;
    real *H = s->qp.H + stage * w * w;
    if (weight == 0) return;
    add(n, s->qp.g + stage * w, 2 * weight * value, row);
    for (size_t i = 0; i < n; i++)
        if (row[i] != 0) add(n - i, H + i * n + i, 2 * weight * row[i], row + i);
}

/* The cost of a followed coordinate: its errors and Jacobians at both ends of an interval. */
typedef struct {
    real tracking, rates, accelerations, error, rate, next_error, next_rate, correction;
    const real *J, *next_J;
} follow;

/* Return the share of a node in an integral over time. */
static real node_share(const mpc *s, size_t k)
{
    return ((k ? s->h[k - 1] : 0) + (k < s->N ? s->h[k] : 0)) / 2;
}

static void add_followed(mpc *s, size_t k, const follow *c)
{
    const size_t n = s->n, a = s->a, w = a + 2 * n;
    const real h = s->h[k], share = node_share(s, k);
    const real *C = s->qp.C + k * 2 * n * w;
    real *row = s->row;
    memset(row, 0, w * sizeof(real));
    if (k > 0) {
        memcpy(row + a, c->J, n * sizeof(real));
        add_square(s, k, w, share * c->tracking, c->error, row);
        memset(row, 0, w * sizeof(real));
        memcpy(row + a + n, c->J, n * sizeof(real));
        add_square(s, k, w, share * c->rates, c->rate, row);
    }
    for (size_t i = 0; i < n; i++) row[a + n + i] = -c->J[i];
    for (size_t i = 0; i < n; i++) add(w, row, c->next_J[i], C + (n + i) * w);
    /* C acts on the state at the end of the interval, which the motion meets only up to its defect */
    const real defect = dot(n, c->next_J, s->qp.c + k * 2 * n + n);
    add_square(s, k, w, c->accelerations / h, c->next_rate + defect - c->rate - h * c->correction, row);
    if (k + 1 < s->N) return;
    const real both = sqrt(c->tracking * c->accelerations), slope = sqrt(c->rates + 2 * both);
    const real last = slope * sqrt(c->accelerations), cross = last > 0 ? both / last : 0;
    const real first = slope * sqrt(c->tracking) - both * cross;
    memset(row, 0, w * sizeof(real));
    memcpy(row, c->next_J, n * sizeof(real));
    add_square(s, k + 1, 2 * n, first + h / 2 * c->tracking, c->next_error, row);
    for (size_t i = 0; i < n; i++) row[n + i] = row[i], row[i] *= cross;
    add_square(s, k + 1, 2 * n, last, c->next_rate + cross * c->next_error, row);
}

/* Add the costs of forces and speeds of a stage, which are diagonal. */
static void add_diagonal(mpc *s, size_t k)
{
    const real h = s->h[k < s->N ? k : 0];
    const size_t n = s->n, a = s->a, w = a + 2 * n, first = k < s->N ? a : 0, width = k < s->N ? w : 2 * n;
    real *H = s->qp.H + k * w * w, *g = s->qp.g + k * w;
    for (size_t i = 0; k < s->N && i < a; i++) {
        const real *f = s->f + k * a + i, last = k ? f[-(ptrdiff_t)a] : s->before[i], next = k + 1 < s->N ? f[a] : *f;
        H[i * w + i] += 2 * h * s->forces_cost[i] + 8 * s->force_rates[i] / h; /* at least the exact Hessian */
        g[i] += 2 * h * s->forces_cost[i] * (*f - s->f_p[i]) + 2 * s->force_rates[i] / h * (2 * *f - last - next);
    }
    for (size_t j = 0; k > 0 && j < n; j++) {
        const size_t i = first + n + j;
        const real weight = 2 * node_share(s, k) * s->speeds[j];
        H[i * width + i] += weight + 1e-9;
        H[(i - n) * width + i - n] += 1e-9;
        g[i] += weight * s->x[(k * 2 + 1) * n + j];
    }
}

static void add_costs(mpc *s, const real *correction)
{
    const size_t n = s->n, r = s->r, w = s->a + 2 * n;
    memset(s->qp.H, 0, (s->N * w * w + 4 * n * n) * sizeof(real));
    memset(s->qp.g, 0, (s->N * w + 2 * n) * sizeof(real));
    for (size_t k = 0; k < s->N; k++) {
        const real *e = s->error + k * r, *rate = s->rate + k * r, *J = s->J + k * r * n, *x = s->x + k * 2 * n;
        for (size_t i = 0; i < r; i++) {
            const follow c = {s->tracking[i], s->tracking_rates[i], s->accelerations[i], e[i], rate[i], e[r + i],
                              rate[r + i], correction[i], J + i * n, J + (r + i) * n};
            add_followed(s, k, &c);
        }
        for (size_t j = 0; s->has_tasks && j < n; j++) {
            const real *P = s->null + (k * n + j) * n, *next = P + n * n;
            const follow c = {s->posture[j], s->posture_rates[j], s->posture_accelerations[j],
                              dot(n, P, x) - dot(n, P, s->q0), dot(n, P, x + n),
                              dot(n, next, x + 2 * n) - dot(n, next, s->q0), dot(n, next, x + 3 * n), 0, P, next};
            add_followed(s, k, &c);
        }
    }
    for (size_t k = 0; k <= s->N; k++) add_diagonal(s, k);
}

/* Set the bounds of the changes of forces and states. A force with one possible value does not change. */
static void set_bounds(mpc *s)
{
    const size_t n = s->n, a = s->a, w = a + 2 * n;
    for (size_t k = 0; k <= s->N; k++) {
        const size_t first = k * w, states = first + (k < s->N ? a : 0);
        for (size_t i = 0; k < s->N && i < a; i++) {
            const real low = k ? s->f_min[i] : s->first_min[i], high = k ? s->f_max[i] : s->first_max[i];
            real *f = s->f + k * a + i;
            const int is_fixed = !(high > low);
            if (is_fixed) *f = low;
            s->qp.low[first + i] = is_fixed ? -INFINITY : low - *f;
            s->qp.high[first + i] = is_fixed || high > UNLIMITED ? INFINITY : high - *f;
            for (size_t l = 0; is_fixed && l < 2 * n; l++) s->qp.C[(k * 2 * n + l) * w + i] = 0;
        }
        for (size_t j = 0; k > 0 && j < n; j++) {
            const real *x = s->x + k * 2 * n + j;
            s->qp.low[states + j] = s->q_min[j] - x[0], s->qp.high[states + j] = s->q_max[j] - x[0];
            s->qp.low[states + n + j] = -s->qd_max[j] - x[n], s->qp.high[states + n + j] = s->qd_max[j] - x[n];
            s->qp.penalty[states + j] = s->qp.penalty[states + n + j] = node_share(s, k) * s->limit_penalty[j];
        }
    }
}

/* Compute one step of the motion. Return nonzero without a solution. */
static int improve(mpc *s, const real *now, const real *correction, const real *load)
{
    const size_t n = 2 * s->n, a = s->a, w = a + n, N = s->N;
    for (size_t i = 0; i < N * a; i++) { /* bounds may have changed */
        const real *low = i < a ? s->first_min : s->f_min, *high = i < a ? s->first_max : s->f_max;
        s->f[i] = clip(s->f[i], low[i % a], high[i % a]);
    }
    if (s->model.intervals(s->model.self, s->h, s->x, s->f, load, s->ends, s->qp.C)) return 1;
    for (size_t i = 0; i < N * n; i++) s->qp.c[i] = s->ends[i] - s->x[n + i];
    compare(s, now);
    set_bounds(s);
    add_costs(s, correction);
    memset(s->qp.v, 0, (N * w + n) * sizeof(real));
    s->qp.tolerance[0] = s->tolerance[0], s->qp.tolerance[1] = REST;
    const int status = stage_qp_solve(s->program, (int)s->iterations[0]);
    s->used[0] += (real)stage_qp_iterations(s->program);
    if (status != STAGE_QP_SOLVED) return 1;
    for (size_t k = 0; k <= N; k++) {
        const real *v = s->qp.v + k * w;
        if (k < N) add(a, s->f + k * a, 1, v);
        add(n, s->x + k * n, 1, v + (k < N ? a : 0));
    }
    return 0;
}

int mpc_solve(void *self, const real *q, const real *qd, const real *reference, const real *correction,
              const real *load, real *forces, real *slack)
{
    mpc *s = self;
    const size_t n = s->n, a = s->a;
    const int is_first = s->planned[0] == 0;
    divide(s);
    if (is_first) rest(s, q);
    memcpy(s->before, s->f, a * sizeof(real));
    if (!is_first)
        shift(s);
    memcpy(s->x, q, n * sizeof(real));
    memcpy(s->x + n, qd, n * sizeof(real));
    s->planned[0] = 0;
    s->used[0] = 0;
    for (int step = 0; step < (is_first ? FIRST_STEPS : 1); step++)
        if (improve(s, reference, correction, load)) return COMPUTED_TORQUE_NEXT;
    s->planned[0] = 1;
    for (size_t i = 0; i < a; i++) forces[i] = clip(s->f[i], s->first_min[i], s->first_max[i]);
    memset(slack, 0, s->r * sizeof(real));
    return COMPUTED_TORQUE_SOLVED;
}
