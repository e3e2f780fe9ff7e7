/* Cholesky factor of a symmetric matrix over the rows: S = U'U, U upper triangular, row by row. */
#include "state.h"

#include <math.h>
#include <string.h>

/* A pivot below this is a rounding error: absolutely, since rows have length 1; and relative to the diagonal
   entry of the row. */
static const real MIN_PIVOT = PRECISE(1e-14, 1e-7), MIN_SHARE = PRECISE(1e-15, 1e-7);

/* Absolute value of an entry that is treated as zero. */
static const real ZERO = PRECISE(1e-200, 1e-30);

/* Compute S += weight a a'. */
static void add_column(dual_newton *s, const real *a, real weight)
{
    const size_t m = s->m;
    for (size_t j = 0; j < m; j++)
        if (a[j] != 0) add(m - j, s->factor + j * m + j, weight * a[j], a + j);
}

/* Factorise. The diagonal is stored inverted, so that solving needs no division. */
static void decompose(dual_newton *s)
{
    const size_t m = s->m;
    real *U = s->factor;
    for (size_t k = 0; k < m; k++) {
        real *row = U + k * m;
        row[k] = 1 / sqrt(larger(row[k], s->pivot[k]));
        for (size_t j = k + 1; j < m; j++) row[j] *= row[k];
        for (size_t j = k + 1; j < m; j++)
            if (row[j] != 0) add(m - j, U + j * m + j, -row[j], row + j);
    }
}

static void clear(dual_newton *s)
{
    memset(s->factor, 0, s->m * s->m * sizeof(real));
}

void factor_build(dual_newton *s, real ridge)
{
    clear(s);
    for (size_t j = 0; j < s->m; j++) s->factor[j * s->m + j] = s->eps[j] + ridge;
    for (size_t i = 0; i < s->n; i++)
        if (!s->side[i]) add_column(s, s->sA + i * s->m, 1);
    for (size_t j = 0; j < s->m; j++) s->pivot[j] = MIN_PIVOT;
    decompose(s);
}

void factor_weighted(dual_newton *s, const real *rows, real ridge)
{
    clear(s);
    for (size_t j = 0; j < s->m; j++) s->factor[j * s->m + j] = rows[j];
    for (size_t i = 0; i < s->n; i++)
        if (s->weight[i] > 0) add_column(s, s->sA + i * s->m, s->weight[i]);
    for (size_t j = 0; j < s->m; j++) {
        real *entry = s->factor + j * s->m + j;
        s->pivot[j] = MIN_SHARE * *entry + ZERO;
        *entry += ridge * *entry + ZERO;
    }
    decompose(s);
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
