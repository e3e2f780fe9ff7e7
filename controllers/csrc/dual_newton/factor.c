/* Cholesky's factor of the Newton matrix: S = U'U, U upper, row by row. */
#include "state.h"

#include <math.h>
#include <string.h>

/* Below this a pivot is rounding error: rows have length 1. */
static const real SMALLEST_PIVOT = PRECISE(1e-14, 1e-7);

static void assemble(dual_newton *s, real ridge)
{
    const size_t n = s->n, m = s->m;
    real *U = s->factor;
    memset(U, 0, m * m * sizeof *U);
    for (size_t j = 0; j < m; j++) U[j * m + j] = s->eps[j] + ridge;
    for (size_t i = 0; i < n; i++) {
        if (s->side[i]) continue;
        const real *a = s->sA + i * m;
        for (size_t j = 0; j < m; j++)
            if (a[j] != 0) add(m - j, U + j * m + j, a[j], a + j);
    }
}

/* The diagonal is kept inverted: a solution then divides by nothing. */
void factor_build(dual_newton *s, real ridge)
{
    const size_t m = s->m;
    real *U = s->factor;
    assemble(s, ridge);
    for (size_t k = 0; k < m; k++) {
        real *row = U + k * m;
        row[k] = 1 / sqrt(larger(row[k], SMALLEST_PIVOT));
        for (size_t j = k + 1; j < m; j++) row[j] *= row[k];
        for (size_t j = k + 1; j < m; j++)
            if (row[j] != 0) add(m - j, U + j * m + j, -row[j], row + j);
    }
}

void factor_solve(const dual_newton *s, const real *r, real *d)
{
    const size_t m = s->m;
    const real *U = s->factor;
    memmove(d, r, m * sizeof *d);
    for (size_t k = 0; k < m; k++) {
        d[k] *= U[k * m + k];
        if (k + 1 < m) add(m - k - 1, d + k + 1, -d[k], U + k * m + k + 1);
    }
    for (size_t k = m; k-- > 0;)
        d[k] = (d[k] - dot(m - k - 1, U + k * m + k + 1, d + k + 1)) * U[k * m + k];
}
