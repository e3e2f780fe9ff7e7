/* The scaled problem. All inputs of the caller are checked. */
#include "state.h"

#include <math.h>

static int scale_cost(dual_newton *s)
{
    for (size_t i = 0; i < s->n; i++) {
        s->root[i] = sqrt(s->H_diagonal[i]);
        s->sg[i] = s->g[i] / s->root[i];
        if (!(s->root[i] > 0) || !isfinite(s->root[i]) || !isfinite(s->sg[i]))
            return DUAL_NEWTON_WRONG_COST;
    }
    return DUAL_NEWTON_SOLVED;
}

static int scale_bounds(dual_newton *s)
{
    for (size_t i = 0; i < s->n; i++) {
        if (!(s->lb[i] <= s->ub[i]) || s->lb[i] == INFINITY || s->ub[i] == -INFINITY)
            return DUAL_NEWTON_WRONG_BOUNDS;
        s->low[i] = s->lb[i] * s->root[i];
        s->high[i] = s->ub[i] * s->root[i];
    }
    return DUAL_NEWTON_SOLVED;
}

/* Compute the norms of the rows. A row of zeros gets the largest norm, to scale its right side. */
static int row_norms(dual_newton *s)
{
    const size_t n = s->n, m = s->m;
    real longest = 0;
    for (size_t j = 0; j < m; j++) s->norm[j] = 0;
    for (size_t i = 0; i < n; i++) {
        const real *column = s->A + i * m, scale = 1 / s->root[i];
        real *scaled = s->sA + i * m;
        for (size_t j = 0; j < m; j++) scaled[j] = column[j] * scale;
        for (size_t j = 0; j < m; j++) s->norm[j] += scaled[j] * scaled[j];
    }
    for (size_t j = 0; j < m; j++) {
        if (!isfinite(s->norm[j])) return DUAL_NEWTON_WRONG_ROWS;
        longest = larger(longest, s->norm[j] = sqrt(s->norm[j]));
    }
    for (size_t j = 0; j < m; j++)
        if (s->norm[j] == 0) s->norm[j] = longest > 0 ? longest : 1;
    return DUAL_NEWTON_SOLVED;
}

static int scale_rows(dual_newton *s)
{
    const size_t n = s->n, m = s->m;
    real *inverse = s->size;
    if (row_norms(s)) return DUAL_NEWTON_WRONG_ROWS;
    for (size_t j = 0; j < m; j++) {
        inverse[j] = 1 / s->norm[j];
        s->sb[j] = s->b[j] * inverse[j];
        s->eps[j] = s->softness[j] * inverse[j] * inverse[j];
        s->lam[j] = s->start[j] * s->norm[j];
        if (!isfinite(s->sb[j]) || !(s->softness[j] >= 0) || !isfinite(s->eps[j]) || !isfinite(s->lam[j]))
            return DUAL_NEWTON_WRONG_ROWS;
    }
    for (size_t i = 0; i < n; i++) {
        real *scaled = s->sA + i * m;
        for (size_t j = 0; j < m; j++) scaled[j] *= inverse[j];
    }
    return DUAL_NEWTON_SOLVED;
}

int scale_problem(dual_newton *s)
{
    const int cost = scale_cost(s), bounds = cost ? cost : scale_bounds(s);
    return bounds ? bounds : scale_rows(s);
}
