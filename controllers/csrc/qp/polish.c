/* Final computation: with the correct active bounds, the optimum is the solution of linear equations. It is
   refined until only rounding errors remain. It depends only on the active bounds, not on the start. */
#include "state.h"

#include <math.h>
#include <string.h>

static const real NOISE = PRECISE(2e-16, 1e-7);          /* of a row, relative to the largest terms */
static const real MAX_NOISE = PRECISE(1e-9, 1e-4);      /* the same, relative to the terms of the row */
static const real EXACT = PRECISE(3e-16, 2e-7);          /* the same: further refinement is useless */
static const real NEAR = PRECISE(1e-10, 1e-5);           /* distance from a bound, relative to the terms of x */
static const real DUAL_TOLERANCE = PRECISE(1e-12, 1e-6); /* of a variable, relative to its terms */
static const real CLOSE_DUAL = PRECISE(1e-14, 3e-7);     /* the same, for large multipliers */
static const real RIDGE = PRECISE(1e-13, 2e-7);          /* for candidate sets of bounds */
enum { MAX_REFINEMENTS = 8 };

/* Return whether the full step stays, except for rounding errors, in the piece for which it was computed. */
static int stays_in_piece(const dual_newton *s)
{
    for (size_t i = 0; i < s->n; i++) {
        const real v = s->v[i] + s->dv[i], x = clip(v, s->low[i], s->high[i]);
        const real expected = s->side[i] ? s->sx[i] : v, size = fabs(x) + fabs(s->v[i]) + fabs(s->sg[i]);
        if (!(fabs(x - expected) <= NEAR * size)) return 0;
    }
    return 1;
}

/* Return the maximum residual of a row, relative to its terms; infinite if a value is NaN. */
static real relative_residual(const dual_newton *s)
{
    real largest = 0, worst = 0;
    for (size_t j = 0; j < s->m; j++) largest = larger(largest, s->size[j]);
    for (size_t j = 0; j < s->m; j++) {
        const real noise = smaller(NOISE * largest, MAX_NOISE * s->size[j]), rest = fabs(s->rest[j]) - noise;
        if (isnan(rest)) return INFINITY;
        if (rest > worst * s->size[j]) worst = rest / s->size[j];
    }
    return worst;
}

/* Variables at their bounds stay there; the others and the multipliers start from zero multipliers. */
static void begin(dual_newton *s)
{
    memset(s->end_lam, 0, s->m * sizeof(real));
    for (size_t i = 0; i < s->n; i++)
        s->end_x[i] = s->side[i] < 0 ? s->low[i] : s->side[i] > 0 ? s->high[i] : -s->sg[i];
}

/* Correct x directly. It is not computed from the multipliers, since large multipliers would cost digits. */
static void correct(dual_newton *s)
{
    factor_solve(s, s->rest, s->correction);
    add(s->m, s->end_lam, 1.0, s->correction);
    for (size_t i = 0; i < s->n; i++)
        if (!s->side[i]) s->end_x[i] += dot(s->m, s->sA + i * s->m, s->correction);
}

/* Refine. Return the remaining relative residual. */
static real refine(dual_newton *s)
{
    real before = INFINITY;
    begin(s);
    for (int k = 0; k < MAX_REFINEMENTS; k++) {
        dual_residual(s, s->end_x, s->end_lam, s->rest, s->size);
        const real now = relative_residual(s);
        if (k && (now <= EXACT || !(now < 0.5 * before))) break;
        correct(s);
        before = now;
    }
    for (size_t i = 0; i < s->n; i++) s->end_x[i] = clip(s->end_x[i], s->low[i], s->high[i]);
    dual_residual(s, s->end_x, s->end_lam, s->rest, s->size);
    return relative_residual(s);
}

/* Return the maximum violation of the dual conditions by end_x and lam, relative to the terms; infinite if a
   value is NaN. */
static real dual_violation(const dual_newton *s, const real *lam)
{
    real worst = 0;
    for (size_t i = 0; i < s->n; i++) {
        const real *a = s->sA + i * s->m, x = s->end_x[i];
        real v = -s->sg[i], size = fabs(s->sg[i]) + fabs(x);
        for (size_t j = 0; j < s->m; j++) {
            const real term = a[j] * lam[j];
            v += term;
            size += fabs(term);
        }
        const real off = fabs(clip(v, s->low[i], s->high[i]) - x);
        if (isnan(off)) return INFINITY;
        if (off > worst * size) worst = off / size;
    }
    return worst;
}

/* Return whether the iterate is already the optimum. The remaining step then consists of rounding errors,
   which may be large in directions that do not affect any variable. */
static int is_optimal(dual_newton *s, real tolerance)
{
    real largest = 0, rest = 0;
    for (size_t i = 0; i < s->n; i++) largest = larger(largest, fabs(s->sx[i]));
    for (size_t j = 0; j < s->m; j++) {
        largest = larger(largest, fabs(s->sb[j]));
        rest = larger(rest, fabs(s->r[j]));
    }
    if (rest > NEAR * largest) return 0; /* skips the accurate comparison */
    dual_residual(s, s->sx, s->lam, s->rest, s->size);
    return relative_residual(s) <= tolerance;
}

/* Compute the residuals of end_x with the better of two vectors of multipliers, in end_lam. Return 1 if they
   are small. Multipliers are not unique if bounds leave too few variables; in this case the multipliers of
   the step are suitable. */
static int is_verified(dual_newton *s, real rest, real tolerance, real dual)
{
    if (rest > tolerance) return 0;
    s->residuals[0] = rest;
    s->residuals[1] = dual_violation(s, s->end_lam);
    if (s->residuals[1] <= tolerance && s->residuals[1] <= dual) return 1;
    for (size_t j = 0; j < s->m; j++) s->end_lam[j] = s->lam[j] + s->d[j];
    s->residuals[1] = dual_violation(s, s->end_lam);
    return s->residuals[1] <= dual;
}

static int accept(dual_newton *s)
{
    memcpy(s->lam, s->end_lam, s->m * sizeof(real));
    memcpy(s->sx, s->end_x, s->n * sizeof(real));
    return 1;
}

/* Verify the iterate itself, if the equations of the bounds do not result in the optimum. */
static int iterate_is_verified(dual_newton *s, real tolerance)
{
    memcpy(s->end_x, s->sx, s->n * sizeof(real));
    memcpy(s->end_lam, s->lam, s->m * sizeof(real));
    dual_residual(s, s->end_x, s->end_lam, s->rest, s->size);
    return is_verified(s, relative_residual(s), tolerance, DUAL_TOLERANCE);
}

int polish(dual_newton *s, real tolerance)
{
    const int is_left = !stays_in_piece(s);
    if (is_left && !is_optimal(s, tolerance)) return 0;
    if (is_left) memset(s->d, 0, s->m * sizeof(real));
    if (is_verified(s, refine(s), tolerance, DUAL_TOLERANCE)) return accept(s);
    /* Variables that are at their bounds with zero multipliers may be inaccurate in the equations, and so
       may be all variables if the equations are ill-conditioned: the iterate itself may be better. */
    if (!is_left && !is_optimal(s, tolerance)) return 0;
    return iterate_is_verified(s, tolerance) && accept(s);
}

int polish_at_bounds(dual_newton *s, real tolerance)
{
    memset(s->d, 0, s->m * sizeof(real));
    factor_build(s, RIDGE);
    return is_verified(s, refine(s), tolerance, CLOSE_DUAL) && accept(s);
}

int polish_here(dual_newton *s, real tolerance)
{
    memset(s->d, 0, s->m * sizeof(real));
    return iterate_is_verified(s, tolerance) && accept(s);
}

void measure(dual_newton *s)
{
    int is_number = 1;
    for (size_t i = 0; i < s->n; i++) is_number &= isfinite(s->sx[i]) != 0;
    for (size_t j = 0; j < s->m; j++) is_number &= isfinite(s->lam[j]) != 0;
    if (!is_number) {
        memset(s->lam, 0, s->m * sizeof(real));
        dual_evaluate(s);
    }
    iterate_is_verified(s, INFINITY);
}
