/* The Newton iteration. */
#include "state.h"

#include <math.h>
#include <string.h>

/* Bounds of the work: at most FAST_STEPS + APPROACHES (APPROACH_STEPS + SLOW_STEPS) = 144 steps. */
enum { FAST_STEPS = 24, APPROACHES = 5, APPROACH_STEPS = 18, SLOW_STEPS = 6, STEPS_OF_A_WARM_START = 4 };

/* Keeps the Newton matrix regular where rows depend on each other, or too few variables are between
   their bounds: there a step is long, and the search finds how long it may be.                        */
static const real RIDGE = PRECISE(1e-13, 2e-7);

/* Of a row, relative to its terms; and where the way to it was a long one. */
static const real TOLERANCE = PRECISE(1e-13, 1e-5), LOOSE_TOLERANCE = PRECISE(1e-13, 1e-4);

/* The ridge of the first approach, and how it shrinks. */
static const real FIRST_RIDGE = 1e-2, RIDGE_RATIO = PRECISE(1e-2, 1e-1);

/* Of a step with a large ridge, relative to the gradient. */
static const real NEAR_ENOUGH = PRECISE(1e-6, 1e-3);

/* The ridge of Newton's steps after an approach. With few digits none suits all problems: a small one is lost
   where rows nearly depend on each other, a large one slows the others. So each round has another.     */
static real ridge_after(real approach)
{
    (void)approach;
    return PRECISE(RIDGE, 3e-3 * approach);
}

static int is_proof(dual_newton *s, const real *y)
{
    memcpy(s->correction, y, s->m * sizeof(real));
    return certificate_holds(s, s->correction);
}

/* What is left at the least violation is a proof, and so is a direction without a peak. Looking for
   them costs as much as half a step, so few steps do without.                                         */
static int is_infeasible(dual_newton *s, int peak_is_far)
{
    if (!peak_is_far && s->steps <= STEPS_OF_A_WARM_START) return 0;
    return is_proof(s, s->d) || is_proof(s, s->r);
}

/* One step to the peak of the dual value less ridge/2 |lam - centre|^2; is it beyond every bend? */
static int step_to_peak(dual_newton *s, real ridge)
{
    int is_far;
    add(s->m, s->lam, search_peak(s, ridge, &is_far), s->d);
    dual_evaluate(s);
    return is_far;
}

static void newton_direction(dual_newton *s, real ridge)
{
    for (size_t j = 0; j < s->m; j++) s->pull[j] = s->r[j] - ridge * (s->lam[j] - s->centre[j]);
    factor_build(s, ridge);
    factor_solve(s, s->pull, s->d);
    dual_direction(s);
    s->steps++;
}

static int newton(dual_newton *s, int most_steps, real ridge, real tolerance)
{
    for (int step = 0; step < most_steps; step++) {
        memcpy(s->centre, s->lam, s->m * sizeof(real));
        newton_direction(s, ridge);
        if (settle(s, tolerance)) return DUAL_NEWTON_SOLVED;
        if (is_infeasible(s, step_to_peak(s, ridge))) return DUAL_NEWTON_INFEASIBLE;
    }
    return DUAL_NEWTON_NOT_CONVERGED;
}

static real largest(const dual_newton *s, const real *r)
{
    real size = 0;
    for (size_t j = 0; j < s->m; j++) size = larger(size, fabs(r[j]));
    return size;
}

/* A step of the proximal point method: with a large ridge few Newton steps find the peak. */
static void approach(dual_newton *s, real ridge)
{
    memcpy(s->centre, s->lam, s->m * sizeof(real));
    for (int step = 0; step < APPROACH_STEPS; step++) {
        newton_direction(s, ridge);
        if (step && largest(s, s->pull) <= NEAR_ENOUGH * largest(s, s->r)) return;
        step_to_peak(s, ridge);
    }
}

/* Newton's method from the given start; where it wanders among bounds, the slower, surer way from zero:
   multipliers of quite another problem may even be too large for an accurate start.                   */
static int iterate(dual_newton *s)
{
    dual_evaluate(s);
    int status = newton(s, FAST_STEPS, RIDGE, TOLERANCE);
    if (status == DUAL_NEWTON_NOT_CONVERGED) memset(s->lam, 0, s->m * sizeof(real));
    real ridge = FIRST_RIDGE;
    for (int k = 0; k < APPROACHES && status == DUAL_NEWTON_NOT_CONVERGED; k++, ridge *= RIDGE_RATIO) {
        dual_evaluate(s);
        approach(s, ridge);
        status = newton(s, SLOW_STEPS, ridge_after(ridge), LOOSE_TOLERANCE);
    }
    return status;
}

/* In the caller's numbers; a variable at its bound gets the bound itself. */
static void hand_over_x(dual_newton *s)
{
    for (size_t j = 0; j < s->m; j++) s->slack[j] = -s->b[j];
    for (size_t i = 0; i < s->n; i++) {
        const real x = s->sx[i] / s->root[i];
        if (s->sx[i] <= s->low[i])
            s->x[i] = s->lb[i];
        else
            s->x[i] = s->sx[i] >= s->high[i] ? s->ub[i] : clip(x, s->lb[i], s->ub[i]);
        add(s->m, s->slack, s->x[i], s->A + i * s->m);
    }
}

static void hand_over_multipliers(dual_newton *s, const real *lam)
{
    for (size_t j = 0; j < s->m; j++) s->multipliers[j] = lam[j] / s->norm[j];
}

int dual_newton_solve(dual_newton *s)
{
    s->steps = 0;
    s->residuals[0] = s->residuals[1] = NAN;
    const int wrong = scale_problem(s);
    if (wrong) return wrong;
    const int status = iterate(s);
    hand_over_x(s);
    hand_over_multipliers(s, status == DUAL_NEWTON_INFEASIBLE ? s->correction : s->lam);
    if (status == DUAL_NEWTON_SOLVED) memcpy(s->start, s->multipliers, s->m * sizeof(real));
    return status;
}
