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

/* Add to the row of an interval the change of share (error at its begin) + next_share (error at its end),
   for positions (offset 0) or rates (offset n). C v + c is the change of the state at the end. */
static void add_change(mpc *s, size_t k, size_t offset, const follow *c, real share, real next_share)
{
    const size_t n = s->n, a = s->a, w = a + 2 * n;
    const real *C = s->qp.C + (k * 2 * n + offset) * w;
    add(n, s->row + a + offset, share, c->J);
    for (size_t i = 0; next_share != 0 && i < n; i++) add(w, s->row, next_share * c->next_J[i], C + i * w);
}

/* Add h (accelerations^1/2 (e'_k+1 - e'_k)/h + d e' + tracking^1/2 e)^2, see mpc.h: with e and e' at the begin
   of the first interval, which is the law of computed torque, and at the middle of the others, which is stable
   for intervals of any length.
   The rate at the begin is computed as (e_k+1 - e_k)/h - (e'_k+1 - e'_k)/2, which is exact for a constant e''.
   Forces are constant in an interval, so e'' changes with the motion, by j per second: with the exact rate, the
   steady error would be d j h^2 / (12 tracking^1/2), not 0. */
static void add_followed(mpc *s, size_t k, const follow *c)
{
    const size_t n = s->n, w = s->a + 2 * n;
    const real *defect = s->qp.c + k * 2 * n;
    const real h = s->h[k], half = PRECISE(0.5, 0.5f), at_end = k ? half : 0;
    const real stiffness = sqrt(c->tracking), inertia = sqrt(c->accelerations);
    const real damping = sqrt(c->rates + 2 * stiffness * inertia), change = inertia / h;
    const real rate = half * damping - change, next_rate = (k ? half : -half) * damping + change;
    const real mean = k ? 0 : damping / h;
    const real share = (1 - at_end) * stiffness - mean, next_share = at_end * stiffness + mean;
    memset(s->row, 0, w * sizeof(real));
    add_change(s, k, 0, c, share, next_share);
    add_change(s, k, n, c, rate, next_rate);
    const real e = share * c->error + next_share * (c->next_error + dot(n, c->next_J, defect));
    const real rates = rate * c->rate + next_rate * (c->next_rate + dot(n, c->next_J, defect + n));
    add_square(s, k, w, h, e + rates - inertia * c->correction, s->row);
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
