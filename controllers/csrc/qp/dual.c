/* The gradient r of the dual function, and related functions. */
#include "state.h"

#include <math.h>

void dual_evaluate(dual_newton *s)
{
    const size_t n = s->n, m = s->m;
    for (size_t j = 0; j < m; j++) s->r[j] = s->sb[j] - s->eps[j] * s->lam[j];
    for (size_t i = 0; i < n; i++) {
        const real *a = s->sA + i * m, v = dot(m, a, s->lam) - s->sg[i];
        s->v[i] = v;
        s->sx[i] = clip(v, s->low[i], s->high[i]);
        s->side[i] = v <= s->low[i] ? -1 : v >= s->high[i];
        if (s->sx[i] != 0) add(m, s->r, -s->sx[i], a);
    }
}

void dual_direction(dual_newton *s)
{
    for (size_t i = 0; i < s->n; i++) s->dv[i] = dot(s->m, s->sA + i * s->m, s->d);
}

/* Compute r = b - eps lam - A x, and the sum of the absolute terms, for comparison. */
void dual_residual(const dual_newton *s, const real *x, const real *lam, real *r, real *size)
{
    const size_t n = s->n, m = s->m;
    for (size_t j = 0; j < m; j++) {
        r[j] = s->sb[j] - s->eps[j] * lam[j];
        size[j] = fabs(s->sb[j]) + fabs(s->eps[j] * lam[j]);
    }
    for (size_t i = 0; i < n; i++) {
        const real *a = s->sA + i * m;
        for (size_t j = 0; j < m; j++) {
            const real term = a[j] * x[i];
            r[j] -= term;
            size[j] += fabs(term);
        }
    }
}
