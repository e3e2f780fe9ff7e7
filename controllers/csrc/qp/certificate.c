/* Farkas' lemma: y with y'b > max { y'A x : lb <= x <= ub } proves that A x = b is infeasible. */
#include "state.h"

#include <math.h>
#include <string.h>

/* Minimum gap relative to the sum of the terms, far above rounding errors. */
static const real MIN_GAP = PRECISE(1e-12, 1e-5);

/* An infinite bound times a product that should be zero is replaced by this multiple of the largest x. */
static const real INFINITE_BOUND = 1e4;

/* Regularisation of a projection, relative to the matrix; and number of repetitions. */
static const real RIDGE = PRECISE(1e-12, 1e-6);
enum { PROJECTIONS = 2 };

static real bound_value(const dual_newton *s)
{
    real size = 0;
    for (size_t i = 0; i < s->n; i++) {
        if (isfinite(s->low[i])) size = larger(size, fabs(s->low[i]));
        if (isfinite(s->high[i])) size = larger(size, fabs(s->high[i]));
    }
    for (size_t j = 0; j < s->m; j++) size = larger(size, fabs(s->sb[j]));
    return INFINITE_BOUND * size;
}

/* Return whether y is a proof. Variables that it pulls towards an infinite bound get a weight of 1, all
   others of 0. */
static int is_valid_proof(dual_newton *s, const real *y, int *is_clean)
{
    const size_t n = s->n, m = s->m;
    const real far = bound_value(s);
    real gap = 0, terms = 0;
    *is_clean = 1;
    for (size_t j = 0; j < m; j++) {
        gap += y[j] * s->sb[j];
        terms += fabs(y[j] * s->sb[j]);
    }
    for (size_t i = 0; i < n; i++) {
        const real *a = s->sA + i * m;
        real pull = 0, size = 0;
        for (size_t j = 0; j < m; j++) {
            pull += a[j] * y[j];
            size += fabs(a[j] * y[j]);
        }
        const real bound = pull > 0 ? s->high[i] : s->low[i];
        const real reach = isfinite(bound) ? bound : pull > 0 ? far : -far;
        gap -= pull * reach;
        terms += isfinite(bound) ? size * fabs(bound) : 0;
        s->weight[i] = !isfinite(bound) && size > 0;
        if (s->weight[i] > 0) *is_clean = 0;
    }
    return gap > MIN_GAP * terms && gap > 0;
}

/* Remove from y the part that acts on the variables with weights, since otherwise rounding errors would
   prove infeasibility although a large x exists. This part is (A_F A_F')^-1 A_F A_F'y. */
static void project(dual_newton *s, real *y)
{
    const size_t m = s->m;
    real *part = s->rest;
    for (size_t j = 0; j < m; j++) s->size[j] = s->eps[j] > 0;
    factor_weighted(s, s->size, RIDGE);
    for (int k = 0; k < PROJECTIONS; k++) {
        memset(part, 0, m * sizeof(real));
        for (size_t i = 0; i < s->n; i++)
            if (s->weight[i] > 0) add(m, part, dot(m, s->sA + i * m, y), s->sA + i * m);
        factor_solve(s, part, part);
        for (size_t j = 0; j < m; j++) y[j] = s->eps[j] > 0 ? 0 : y[j] - part[j];
    }
}

int is_proof(dual_newton *s, const real *y)
{
    int is_clean;
    real *y_hard = s->correction;
    for (size_t j = 0; j < s->m; j++) y_hard[j] = s->eps[j] > 0 ? 0 : y[j];
    if (!is_valid_proof(s, y_hard, &is_clean)) return 0;
    if (is_clean) return 1;
    project(s, y_hard);
    return is_valid_proof(s, y_hard, &is_clean);
}
