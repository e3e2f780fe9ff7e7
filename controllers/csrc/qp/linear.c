/* Both methods solve a linear program by a finite number of quadratic programs. */
#include "linear.h"

#include "state.h"

#include <math.h>
#include <string.h>

enum { STEPS = 100 };

/* Relative increase of a distance for which rounding errors prevent a solution. */
static const real WIDENING = PRECISE(1e-10, 1e-5);

/* A proof that raises the distance by less than this share of the open interval is loose. */
static const real MIN_PROGRESS = 0.1;

/* Length of the first step of the proximal point method, in distances of the first x from p; smaller if a
   program is not solved; and how often later steps may be ten times longer. */
static const real FIRST_STEP[2] = {100, 1};
enum { LONGER_STEPS = 6 };

/* A step that changes x by less than this share of that distance is the last one. */
static const real MIN_STEP = PRECISE(1e-12, 1e-5);

/* Maximum reduced cost, relative to c, that is treated as zero. */
static const real NO_COST = PRECISE(1e-9, 1e-4);

/* Compute the x nearest to p within the bounds of the program. */
static int nearest_point(dual_newton *s, const real *p)
{
    for (size_t i = 0; i < s->n; i++) s->H_diagonal[i] = 1, s->g[i] = -p[i];
    memset(s->start, 0, s->m * sizeof(real));
    return dual_newton_solve(s);
}

/* ------------------------------------------------------------------------------- the largest distance

   x is feasible for a distance t if A x = b with |x_i - p_i| <= t/c_i within the bounds. If no x is
   feasible, y proves it: y'b > max y'A x. This maximum grows with t; the t at which it reaches y'b is a
   better lower bound for t. The maximum is piecewise linear, and so is the bound over all proofs: after
   finitely many proofs, the minimum t is found exactly. */

static real reach(const real *c, size_t i, real t)
{
    return c[i] > 0 ? t / c[i] : INFINITY;
}

static real upper(box bounds, const real *p, size_t i, real reach)
{
    return larger(bounds.low[i], smaller(bounds.high[i], p[i] + reach));
}

static real lower(box bounds, const real *p, size_t i, real reach)
{
    return smaller(bounds.high[i], larger(bounds.low[i], p[i] - reach));
}

/* Return the minimum t at which the multipliers no longer prove infeasibility. */
static real refuted_distance(const dual_newton *s, box bounds, const real *c, const real *p, real t)
{
    const real *y = s->multipliers;
    for (size_t bend = 0; bend <= 2 * s->n; bend++) {
        real gap = dot(s->m, y, s->b), slope = 0;
        for (size_t i = 0; i < s->n; i++) {
            const real pull = dot(s->m, y, s->A + i * s->m), way = reach(c, i, t);
            if (pull == 0) continue;
            gap -= pull * (pull > 0 ? upper(bounds, p, i, way) : lower(bounds, p, i, way));
            /* whether the distance is the active bound, not the box */
            if (pull > 0 ? p[i] + way < bounds.high[i] : p[i] - way > bounds.low[i])
                slope += fabs(pull) / c[i];
        }
        if (!(gap > 0)) break;
        if (!(slope > 0)) break; /* a proof from rounding errors */
        t += gap / slope;
    }
    return t;
}

/* Return the minimum distance due to the bounds of each x. */
static real min_distance(const dual_newton *s, box bounds, const real *c, const real *p)
{
    real t = 0;
    for (size_t i = 0; i < s->n; i++)
        t = larger(t, c[i] * larger(bounds.low[i] - p[i], p[i] - bounds.high[i]));
    return t;
}

/* Return the maximum distance of x from p. */
static real max_distance(const dual_newton *s, const real *c, const real *p, const real *x)
{
    real t = 0;
    for (size_t i = 0; i < s->n; i++) t = larger(t, c[i] * fabs(x[i] - p[i]));
    return t;
}

/* Compute the x nearest to p of all x that are feasible for a distance. Return an enum dual_newton_status. */
static int fit_distance(dual_newton *s, box bounds, const real *c, const real *p, real t)
{
    for (size_t i = 0; i < s->n; i++) {
        s->lb[i] = lower(bounds, p, i, reach(c, i, t));
        s->ub[i] = upper(bounds, p, i, reach(c, i, t));
    }
    return nearest_point(s, p);
}

int minimize_largest(dual_newton *s, box bounds, const real *c, const real *p, const real *first)
{
    real t = min_distance(s, bounds, c, p), maximum = max_distance(s, c, p, first), wider = WIDENING;
    memset(s->softness, 0, s->m * sizeof(real));
    for (int step = 0; step < STEPS && t < maximum; step++) {
        int status = fit_distance(s, bounds, c, p, t);
        if (status != DUAL_NEWTON_INFEASIBLE && status != DUAL_NEWTON_NOT_CONVERGED) return status;
        real next = status == DUAL_NEWTON_INFEASIBLE ? refuted_distance(s, bounds, c, p, t) : t;
        if (next < t + MIN_PROGRESS * (maximum - t)) { /* loose proof: evaluate the midpoint */
            const real middle = next + (maximum - next) / 2;
            status = fit_distance(s, bounds, c, p, middle);
            if (status == DUAL_NEWTON_INFEASIBLE) next = larger(next, refuted_distance(s, bounds, c, p, middle));
            if (status == DUAL_NEWTON_SOLVED) maximum = smaller(maximum, max_distance(s, c, p, s->x));
        }
        if (next <= t * (1 + WIDENING)) {
            t *= 1 + wider;
            wider *= 2;
        } else
            t = next;
    }
    if (fit_distance(s, bounds, c, p, maximum) != DUAL_NEWTON_SOLVED) memcpy(s->x, first, s->n * sizeof(real));
    return t < maximum ? DUAL_NEWTON_NOT_CONVERGED : DUAL_NEWTON_SOLVED;
}

/* --------------------------------------------------------------------------------- the sum of distances

   With x = p + u - v, and nonnegative u and v, the sum is c'(u + v). The proximal point method,

     u, v <- argmin c'(u + v) + 1/2 |u - u_last|^2_H + 1/2 |v - v_last|^2_H,

   converges to a solution of the linear program, and its multipliers y to a solution of the dual program.
   With a = A'y, the set of solutions consists of all feasible x that are at bounds where |a| > c, at p where
   |a| < c, and on one side of p where |a| = c. Of these, the x nearest to p is returned.

   R. T. Rockafellar, Monotone operators and the proximal point algorithm, SIAM J. Control Optim. 14 (1976). */

static real positive(real x)
{
    return larger(x, 0);
}

static real first_distance(const dual_newton *s, const real *p, const real *first)
{
    real size = 0;
    for (size_t i = 0; i < s->n; i++) size = larger(size, fabs(first[i] - p[i]));
    return size;
}

/* Set the rows, bounds and cost of u and v, which begin at `first`. */
static void split_program(const dual_newton *s, dual_newton *parts, box bounds, const real *c, const real *p, const real *first,
                          real far)
{
    const size_t n = s->n, m = s->m;
    memset(parts->softness, 0, m * sizeof(real));
    memset(parts->start, 0, m * sizeof(real));
    memcpy(parts->b, s->b, m * sizeof(real));
    for (size_t i = 0; i < n; i++) {
        const real *column = s->A + i * m;
        add(m, parts->b, -p[i], column);
        for (size_t j = 0; j < m; j++) {
            parts->A[i * m + j] = column[j];
            parts->A[(n + i) * m + j] = -column[j];
        }
        parts->H_diagonal[i] = parts->H_diagonal[n + i] = c[i] / far;
        parts->lb[i] = positive(bounds.low[i] - p[i]), parts->ub[i] = positive(bounds.high[i] - p[i]);
        parts->lb[n + i] = positive(p[i] - bounds.high[i]), parts->ub[n + i] = positive(p[i] - bounds.low[i]);
        parts->x[i] = positive(first[i] - p[i]), parts->x[n + i] = positive(p[i] - first[i]);
    }
}

/* Iterate to the fixed point; the last u and v are stored in the bounds of s, which are set later. */
static int proximal_points(dual_newton *s, dual_newton *parts, const real *c, real size)
{
    const size_t n = s->n;
    for (int step = 0; step < STEPS; step++) {
        real change = 0;
        memcpy(s->lb, parts->x, n * sizeof(real));
        memcpy(s->ub, parts->x + n, n * sizeof(real));
        for (size_t i = 0; i < 2 * n; i++) parts->g[i] = c[i % n] - parts->H_diagonal[i] * parts->x[i];
        const int status = dual_newton_solve(parts);
        if (status != DUAL_NEWTON_SOLVED) return status;
        for (size_t i = 0; i < n; i++) {
            change = larger(change, fabs(parts->x[i] - s->lb[i]));
            change = larger(change, fabs(parts->x[n + i] - s->ub[i]));
        }
        if (change <= MIN_STEP * size) return DUAL_NEWTON_SOLVED;
        for (size_t i = 0; i < 2 * n && step < LONGER_STEPS; i++) parts->H_diagonal[i] *= (real)0.1;
    }
    return DUAL_NEWTON_NOT_CONVERGED;
}

/* Set the bounds to the set of all solutions, from the multipliers of one solution. */
static void bound_solutions(dual_newton *s, const dual_newton *parts, box bounds, const real *c, const real *p)
{
    for (size_t i = 0; i < s->n; i++) {
        const real low = bounds.low[i], high = bounds.high[i], at_p = clip(p[i], low, high);
        const real a = dot(s->m, s->A + i * s->m, parts->multipliers) / c[i];
        s->lb[i] = a > 1 + NO_COST && isfinite(high) ? high : a > -1 + NO_COST ? at_p : low;
        s->ub[i] = a < -1 - NO_COST ? low : a < 1 - NO_COST ? at_p : high;
    }
}

int minimize_sum(dual_newton *s, dual_newton *parts, box bounds, const real *c, const real *p, const real *first)
{
    const size_t n = s->n;
    const real size = first_distance(s, p, first);
    memset(s->softness, 0, s->m * sizeof(real));
    memcpy(s->x, first, n * sizeof(real));
    if (size == 0) return DUAL_NEWTON_SOLVED;
    int status = DUAL_NEWTON_NOT_CONVERGED;
    for (int attempt = 0; attempt < 2 && status != DUAL_NEWTON_SOLVED; attempt++) {
        split_program(s, parts, bounds, c, p, first, FIRST_STEP[attempt] * size);
        status = proximal_points(s, parts, c, size);
    }
    if (status != DUAL_NEWTON_SOLVED) return status;
    bound_solutions(s, parts, bounds, c, p);
    if (nearest_point(s, p) != DUAL_NEWTON_SOLVED)
        for (size_t i = 0; i < n; i++) s->x[i] = clip(p[i] + parts->x[i] - parts->x[n + i], bounds.low[i], bounds.high[i]);
    return DUAL_NEWTON_SOLVED;
}
