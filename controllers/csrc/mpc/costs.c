#include "costs.h"

#include <string.h>

static const real REGULAR = 1e-9; /* curvature of states without a cost */

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

/* -------------------------------------------------------------------------------- followed coordinates */

/* The cost of a followed coordinate: its errors and Jacobians at both ends of an interval. */
typedef struct {
    real tracking, rates, accelerations, error, rate, next_error, next_rate, correction;
    const real *J, *next_J;
} follow;

/* Set `row` to zero except for J, from a column on. Return it. */
static const real *place(mpc *s, size_t column, const real *J)
{
    memset(s->row, 0, (s->a + 2 * s->n) * sizeof(real));
    memcpy(s->row + column, J, s->n * sizeof(real));
    return s->row;
}

/* Add the costs of the error and its rate at node k. */
static void add_errors(mpc *s, size_t k, const follow *c)
{
    const size_t n = s->n, a = s->a, w = a + 2 * n;
    const real share = mpc_share(s, k);
    add_square(s, k, w, share * c->tracking, c->error, place(s, a, c->J));
    add_square(s, k, w, share * c->rates, c->rate, place(s, a + n, c->J));
}

/* Add accelerations (e'_k+1 - e'_k - h correction)^2 / h. C v + c is the change of the state at the end of
   the interval. */
static void add_acceleration(mpc *s, size_t k, const follow *c)
{
    const size_t n = s->n, a = s->a, w = a + 2 * n;
    const real h = s->h[k], *C = s->qp.C + k * 2 * n * w;
    const real defect = dot(n, c->next_J, s->qp.c + k * 2 * n + n);
    real *row = s->row;
    memset(row, 0, w * sizeof(real));
    for (size_t i = 0; i < n; i++) row[a + n + i] = -c->J[i];
    for (size_t i = 0; i < n; i++) add(w, row, c->next_J[i], C + (n + i) * w);
    add_square(s, k, w, c->accelerations / h, c->next_rate + defect - c->rate - h * c->correction, row);
}

/* Add the cost to go (e, e')' P (e, e') of mpc.h as a sum of squares,

     P = L diag(first, last) L',   last = P_22,   cross = P_12 / last,   first = P_11 - cross P_12,

   and the share h/2 of the last node in the integral of the error. */
static void add_cost_to_go(mpc *s, const follow *c)
{
    const size_t n = s->n, N = s->N;
    const real both = sqrt(c->tracking * c->accelerations), slope = sqrt(c->rates + 2 * both);
    const real last = slope * sqrt(c->accelerations), cross = last > 0 ? both / last : 0;
    const real first = slope * sqrt(c->tracking) - both * cross;
    real *row = s->row;
    place(s, 0, c->next_J);
    add_square(s, N, 2 * n, first + s->h[N - 1] / 2 * c->tracking, c->next_error, row);
    for (size_t i = 0; i < n; i++) row[n + i] = row[i], row[i] *= cross;
    add_square(s, N, 2 * n, last, c->next_rate + cross * c->next_error, row);
}

static void add_followed(mpc *s, size_t k, const follow *c)
{
    if (k > 0) add_errors(s, k, c);
    add_acceleration(s, k, c);
    if (k + 1 == s->N) add_cost_to_go(s, c);
}

static follow followed_coordinate(const mpc *s, size_t k, size_t i, real correction)
{
    const size_t n = s->n, r = s->r, at = k * r + i, next = at + r;
    return (follow){s->tracking[i], s->tracking_rates[i], s->accelerations[i], s->error[at],    s->rate[at],
                    s->error[next], s->rate[next],        correction,          s->J + at * n, s->J + next * n};
}

/* The distance of coordinate j from the posture, in the null space of the tasks. */
static follow followed_posture(const mpc *s, size_t k, size_t j)
{
    const size_t n = s->n;
    const real *x = s->x + k * 2 * n, *P = s->null + (k * n + j) * n, *next = P + n * n;
    return (follow){s->posture[j],
                    s->posture_rates[j],
                    s->posture_accelerations[j],
                    dot(n, P, x) - dot(n, P, s->q0),
                    dot(n, P, x + n),
                    dot(n, next, x + 2 * n) - dot(n, next, s->q0),
                    dot(n, next, x + 3 * n),
                    0,
                    P,
                    next};
}

/* ----------------------------------------------------------------------------------- forces and speeds */

/* Add forces (f - f_p)^2 h + force_rates (f_k - f_k-1)^2 / h. The diagonal is at least the exact Hessian. */
static void add_forces(mpc *s, size_t k)
{
    const size_t a = s->a, w = a + 2 * s->n;
    const real h = s->h[k];
    real *H = s->qp.H + k * w * w, *g = s->qp.g + k * w;
    for (size_t i = 0; i < a; i++) {
        const real *f = s->f + k * a + i, last = k ? f[-(ptrdiff_t)a] : s->before[i], next = k + 1 < s->N ? f[a] : *f;
        H[i * w + i] += 2 * h * s->forces_cost[i] + 8 * s->force_rates[i] / h;
        g[i] += 2 * h * s->forces_cost[i] * (*f - s->f_p[i]) + 2 * s->force_rates[i] / h * (2 * *f - last - next);
    }
}

static void add_speeds(mpc *s, size_t k)
{
    const size_t n = s->n, w = s->a + 2 * n, first = k < s->N ? s->a : 0, width = first + 2 * n;
    real *H = s->qp.H + k * w * w, *g = s->qp.g + k * w;
    for (size_t j = 0; j < n; j++) {
        const size_t i = first + n + j;
        const real weight = 2 * mpc_share(s, k) * s->speeds[j];
        H[i * width + i] += weight + REGULAR;
        H[(i - n) * width + i - n] += REGULAR;
        g[i] += weight * s->x[(k * 2 + 1) * n + j];
    }
}

void mpc_set_costs(mpc *s, const real *correction)
{
    const size_t n = s->n, N = s->N, w = s->a + 2 * n;
    memset(s->qp.H, 0, (N * w * w + 4 * n * n) * sizeof(real));
    memset(s->qp.g, 0, (N * w + 2 * n) * sizeof(real));
    for (size_t k = 0; k < N; k++) {
        for (size_t i = 0; i < s->r; i++) {
            const follow c = followed_coordinate(s, k, i, correction[i]);
            add_followed(s, k, &c);
        }
        for (size_t j = 0; s->has_tasks && j < n; j++) {
            const follow c = followed_posture(s, k, j);
            add_followed(s, k, &c);
        }
    }
    for (size_t k = 0; k < N; k++) add_forces(s, k);
    for (size_t k = 1; k <= N; k++) add_speeds(s, k);
}
