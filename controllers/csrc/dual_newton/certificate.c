/* Farkas' lemma: y with y'b > max { y'A x : lb <= x <= ub } proves that A x = b has no solution. */
#include "state.h"

#include <math.h>

/* The gap must exceed this share of the terms added up: rounding errors are far below. */
static const real SMALLEST_GAP = PRECISE(1e-10, 1e-5);

/* An infinite bound, multiplied by what should be zero, is taken for this many times the largest x. */
static const real FAR = 1e4;

static real far_away(const dual_newton *s)
{
    real size = 0;
    for (size_t i = 0; i < s->n; i++) size = larger(size, fabs(s->sx[i]));
    for (size_t j = 0; j < s->m; j++) size = larger(size, fabs(s->sb[j]));
    return FAR * size;
}

int certificate_holds(const dual_newton *s, real *y)
{
    const size_t n = s->n, m = s->m;
    const real far = far_away(s);
    real gap = 0, terms = 0;
    for (size_t j = 0; j < m; j++) {
        if (s->eps[j] > 0) y[j] = 0;
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
    }
    return gap > SMALLEST_GAP * terms && gap > 0;
}
