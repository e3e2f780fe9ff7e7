/* Interior point method, for problems in which the Newton iteration cycles among the bounds: Mehrotra's
   predictor-corrector method, with separate variables for the distances to the bounds and for their
   multipliers:

     low_gap = x - low > 0,   high_gap = high - x > 0,
     b - eps lam - A x = r -> 0,   A'lam - g - x + low_push - high_push = 0,   gap push -> 0

   x is not computed from the multipliers, since large multipliers would cost digits.

   S. Mehrotra, On the implementation of a primal-dual interior point method, SIAM J. Optim. 2 (1992). */
#include "state.h"

#include <math.h>
#include <string.h>

enum { MAX_STEPS = 60, REFINEMENTS = 1 };

/* Tolerance of a row, relative to its terms; and at the end, when rounding errors prevent a better result. */
static const real TOLERANCE = PRECISE(1e-13, 1e-5), LAST_TOLERANCE = PRECISE(1e-7, 1e-4);

/* Minimum share of the products that a stuck step leaves; minimum length of a full step. */
static const real STUCK_SHARE = 0.1, NEARLY_FULL = 0.9;

/* A product that does not affect the cost, relative to the cost. */
static const real SMALL_PRODUCT = PRECISE(1e-15, 1e-10);

/* Termination: a product of gap and push of this size, relative to the first. */
static const real MIN_PRODUCT = PRECISE(1e-30, 1e-15);

/* Length of a step relative to the step at which a gap or a push becomes zero. */
static const real STEP_SHARE = 0.995;

/* Regularisation for rows that depend on each other, relative to the diagonal. */
static const real RIDGE = PRECISE(1e-15, 1e-6), FIRST_RIDGE = PRECISE(1e-8, 1e-4);

/* Initial gap, relative to the distance of the bounds; and initial push, relative to the gaps. Multipliers
   may be large. */
static const real FIRST_GAP = 0.1, FIRST_PUSH = PRECISE(1e4, 1);

static int is_fixed(const dual_newton *s, size_t i)
{
    return s->low[i] == s->high[i];
}

static int has_low(const dual_newton *s, size_t i)
{
    return isfinite(s->low[i]) && !is_fixed(s, i);
}

static int has_high(const dual_newton *s, size_t i)
{
    return isfinite(s->high[i]) && !is_fixed(s, i);
}

/* Compute the x nearest to -g with A x = b, ignoring the bounds. Return its maximum distance from the
   bounds. */
static real begin_unbounded(dual_newton *s)
{
    const size_t n = s->n, m = s->m;
    real outside = 0;
    memset(s->lam, 0, m * sizeof(real));
    for (size_t i = 0; i < n; i++) {
        s->inner_x[i] = clip(-s->sg[i], s->low[i], s->high[i]);
        s->weight[i] = !is_fixed(s, i);
    }
    dual_residual(s, s->inner_x, s->lam, s->rest, s->size);
    factor_weighted(s, s->eps, FIRST_RIDGE);
    factor_solve(s, s->rest, s->correction);
    for (size_t i = 0; i < n; i++) {
        const real x = s->inner_x[i] + s->weight[i] * dot(m, s->sA + i * m, s->correction);
        s->inner_x[i] = clip(x, s->low[i], s->high[i]);
        outside = larger(outside, fabs(x - s->inner_x[i]));
    }
    return outside;
}

static void begin(dual_newton *s)
{
    const real outside = begin_unbounded(s);
    for (size_t i = 0; i < s->n; i++) {
        const real between = s->high[i] - s->low[i], x = s->inner_x[i];
        const real away = isfinite(between) ? FIRST_GAP * between : larger(outside, 1e-3 * (1 + fabs(x)));
        real *low = s->low_gap + i, *high = s->high_gap + i;
        s->low_change[i] = s->high_change[i] = 0;
        if (has_low(s, i)) *low = larger(x - s->low[i], away);
        if (has_low(s, i) && has_high(s, i)) *low = larger(away, between - *low < away ? between - away : *low);
        if (has_high(s, i)) *high = has_low(s, i) ? between - *low : larger(s->high[i] - x, away);
        if (has_low(s, i)) s->inner_x[i] = s->low[i] + *low;
        if (has_high(s, i) && !has_low(s, i)) s->inner_x[i] = s->high[i] - *high;
        s->low_push[i] = FIRST_PUSH * (outside + *low);
        s->high_push[i] = FIRST_PUSH * (outside + *high);
    }
}

/* Return the mean product of gap and push after a step. */
static real mean_product(const dual_newton *s, real step)
{
    real sum = 0, count = 0;
    for (size_t i = 0; i < s->n; i++) {
        const real by = step * s->dx[i];
        const real low = s->low_push[i] + step * s->low_change[i];
        const real high = s->high_push[i] + step * s->high_change[i];
        if (has_low(s, i)) sum += (s->low_gap[i] + by) * low, count++;
        if (has_high(s, i)) sum += (s->high_gap[i] - by) * high, count++;
    }
    return count > 0 ? sum / count : 0;
}

/* Compute the residuals: r, and v = A'lam - g - x. The weights are dx/dv. */
static void evaluate(dual_newton *s)
{
    dual_residual(s, s->inner_x, s->lam, s->r, s->size);
    for (size_t i = 0; i < s->n; i++) {
        real stiffness = 1;
        s->v[i] = dot(s->m, s->sA + i * s->m, s->lam) - s->sg[i] - s->inner_x[i];
        if (has_low(s, i)) stiffness += s->low_push[i] / s->low_gap[i];
        if (has_high(s, i)) stiffness += s->high_push[i] / s->high_gap[i];
        s->weight[i] = is_fixed(s, i) ? 0 : 1 / stiffness;
        s->dx[i] = s->low_change[i] = s->high_change[i] = 0;
    }
}

/* Compute d and dx with A dx + eps d = r, so that v + A'd - dx + goal = 0 for variables not at bounds. */
static void solve_equations(dual_newton *s)
{
    const size_t n = s->n, m = s->m;
    memset(s->d, 0, m * sizeof(real));
    for (size_t i = 0; i < n; i++) s->dx[i] = s->weight[i] * s->goal[i];
    for (int k = 0; k <= REFINEMENTS; k++) {
        for (size_t j = 0; j < m; j++) s->rest[j] = s->r[j] - s->eps[j] * s->d[j];
        for (size_t i = 0; i < n; i++) add(m, s->rest, -s->dx[i], s->sA + i * m);
        factor_solve(s, s->rest, s->correction);
        add(m, s->d, 1, s->correction);
        for (size_t i = 0; i < n; i++) s->dx[i] += s->weight[i] * dot(m, s->sA + i * m, s->correction);
    }
}

/* Compute the step towards gap-push products of `product`, with the second-order term of the previous step. */
static void direction(dual_newton *s, real product)
{
    for (size_t i = 0; i < s->n; i++) {
        s->low_change[i] = product - s->dx[i] * s->low_change[i];
        s->high_change[i] = product + s->dx[i] * s->high_change[i];
        s->goal[i] = s->v[i];
        if (has_low(s, i)) s->goal[i] += s->low_change[i] / s->low_gap[i];
        if (has_high(s, i)) s->goal[i] -= s->high_change[i] / s->high_gap[i];
    }
    solve_equations(s);
    for (size_t i = 0; i < s->n; i++) {
        const real dx = s->dx[i], low = s->low_push[i], high = s->high_push[i];
        if (has_low(s, i)) s->low_change[i] = (s->low_change[i] - low * dx) / s->low_gap[i] - low;
        if (has_high(s, i)) s->high_change[i] = (s->high_change[i] + high * dx) / s->high_gap[i] - high;
    }
}

static real largest(const dual_newton *s, const real *r)
{
    real size = 0;
    for (size_t j = 0; j < s->m; j++) size = larger(size, fabs(r[j]));
    return size;
}

static real limit_step(real step, real value, real change)
{
    return value < -step * change ? -value / change : step;
}

/* Return the step length at which a gap or a push becomes zero, slightly more than 1 at most. */
static real longest_step(const dual_newton *s)
{
    real step = 1 / STEP_SHARE;
    for (size_t i = 0; i < s->n; i++) {
        if (has_low(s, i)) step = limit_step(step, s->low_gap[i], s->dx[i]);
        if (has_low(s, i)) step = limit_step(step, s->low_push[i], s->low_change[i]);
        if (has_high(s, i)) step = limit_step(step, s->high_gap[i], -s->dx[i]);
        if (has_high(s, i)) step = limit_step(step, s->high_push[i], s->high_change[i]);
    }
    return step;
}

/* x is computed from the nearer bound. */
static void move(dual_newton *s, real step)
{
    add(s->m, s->lam, step, s->d);
    for (size_t i = 0; i < s->n; i++) {
        const int low = has_low(s, i), high = has_high(s, i);
        s->inner_x[i] += step * s->dx[i];
        if (low) s->low_gap[i] += step * s->dx[i], s->low_push[i] += step * s->low_change[i];
        if (high) s->high_gap[i] -= step * s->dx[i], s->high_push[i] += step * s->high_change[i];
        if (low && !(high && s->high_gap[i] < s->low_gap[i]))
            s->inner_x[i] = s->low[i] + s->low_gap[i];
        else if (high)
            s->inner_x[i] = s->high[i] - s->high_gap[i];
    }
}

/* Return whether the bounds whose push exceeds their gap are the active bounds of the optimum. */
static int is_found(dual_newton *s, real tolerance)
{
    for (size_t i = 0; i < s->n; i++) {
        s->side[i] = is_fixed(s, i) ? -1 : 0;
        if (has_low(s, i) && s->low_push[i] > s->low_gap[i]) s->side[i] = -1;
        if (has_high(s, i) && s->high_push[i] > s->high_gap[i]) s->side[i] = 1;
        s->sx[i] = clip(s->inner_x[i], s->low[i], s->high[i]);
    }
    return polish_at_bounds(s, tolerance);
}

/* Return the share of the products that a step should leave: Mehrotra's cube of the share that the predictor
   leaves. If a full step does not reduce the residual of the rows, the products would vanish before the
   residual does; and if they do not decrease, steps may cycle. */
static real remaining_share(real left, int is_stuck)
{
    const real cube = left * left * left;
    return is_stuck ? larger(cube, STUCK_SHARE) : cube;
}

/* Return whether the problem has soft rows: then it is always feasible, and only the optimum is valid. */
static int has_soft_rows(const dual_newton *s)
{
    for (size_t j = 0; j < s->m; j++)
        if (s->eps[j] > 0) return 1;
    return 0;
}

static int is_near(dual_newton *s, real product)
{
    return product < SMALL_PRODUCT * dot(s->n, s->sx, s->sx) && polish_here(s, TOLERANCE);
}

/* Compute the direction of a step. Return its maximum length. */
static real predict_and_correct(dual_newton *s, real product, int is_stuck)
{
    factor_weighted(s, s->eps, RIDGE);
    direction(s, 0);
    const real left = mean_product(s, clip(longest_step(s), 0, 1));
    direction(s, remaining_share(product > 0 ? left / product : 0, is_stuck) * product);
    return STEP_SHARE * longest_step(s);
}

int interior_point(dual_newton *s)
{
    const int is_soft = has_soft_rows(s);
    real first = 0, product = 0, rest = 0, step = 0;
    begin(s);
    for (int k = 0; k < MAX_STEPS; k++) {
        s->steps++;
        evaluate(s);
        const real product_before = product, rest_before = rest;
        product = mean_product(s, 0), rest = largest(s, s->r);
        if (!k) first = product;
        const int rows_are_stuck = step > NEARLY_FULL && rest > 0.5 * rest_before;
        step = predict_and_correct(s, product, rows_are_stuck || product > 0.5 * product_before);
        if (!isfinite(step * product) || product < MIN_PRODUCT * first) break;
        if (is_proof(s, s->d) || is_proof(s, s->lam)) return DUAL_NEWTON_INFEASIBLE;
        move(s, step);
        if (step > 0.5 && is_found(s, TOLERANCE)) return DUAL_NEWTON_SOLVED;
        if (!is_soft && is_near(s, product)) return DUAL_NEWTON_SOLVED;
    }
    if (is_soft) return polish_here(s, TOLERANCE) ? DUAL_NEWTON_SOLVED : DUAL_NEWTON_NOT_CONVERGED;
    return is_found(s, LAST_TOLERANCE) || polish_here(s, LAST_TOLERANCE) ? DUAL_NEWTON_SOLVED
                                                                         : DUAL_NEWTON_NOT_CONVERGED;
}
