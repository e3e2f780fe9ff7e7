/* The motions that loop joints allow, by chosen coordinates: with J qdd = -J' qd, independent coordinates I
   and dependent coordinates D,

     qdd_D = -J_D^-1 (J_I qdd_I + J' qd),   qdd = N qdd_I + c.

   J has redundant rows; elimination with full pivoting selects independent ones. */
#include "../core.h"

#include "../blob/state.h"
#include "../math/elementary.h"

#include <string.h>

/* Minimum pivot relative to the largest one. */
static const real MIN_SHARE = PRECISE(1e-8, 1e-4);

static real *row_of(core *c, int32_t k)
{
    return c->closure_rows + (size_t)k * (size_t)(c->blob.counts.dofs + 1);
}

static int is_solved(const core *c, int32_t rank, int32_t j)
{
    for (int32_t s = 0; s < rank; s++)
        if ((int32_t)value_of(c->closure_order[s]) == j) return 1;
    return 0;
}

/* Find the row, from `rank` on, and the dependent coordinate of the largest element. */
static real find_pivot(core *c, const real *dependent, int32_t rank, int32_t *row, int32_t *column)
{
    real largest = 0;
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) {
        if (value_of(dependent[j]) == 0 || is_solved(c, rank, j)) continue;
        for (int32_t k = rank; k < c->blob.counts.closures; k++) {
            const real size = fabs(row_of(c, k)[j]);
            if (value_of(size) > value_of(largest)) largest = size, *row = k, *column = j;
        }
    }
    return largest;
}

/* Solve row `pivot`, which moves to `rank`, for a coordinate, and eliminate that coordinate from the other
   rows. */
static void eliminate(core *c, int32_t rank, int32_t pivot, int32_t j)
{
    const int32_t width = c->blob.counts.dofs + 1;
    real *solved = row_of(c, rank), *chosen = row_of(c, pivot);
    const real size = chosen[j];
    for (int32_t i = 0; i < width; i++) {
        const real value = chosen[i] / size;
        chosen[i] = solved[i];
        solved[i] = value;
    }
    for (int32_t k = 0; k < c->blob.counts.closures; k++) {
        real *row = row_of(c, k);
        const real factor = row[j];
        for (int32_t i = 0; k != rank && i < width; i++) row[i] -= factor * solved[i];
    }
}

int core_free_motion(core *c, const real *dependent, const real *qd)
{
    const int32_t n = c->blob.counts.dofs, closures = c->blob.counts.closures;
    real first = 0;
    int32_t rank = 0;
    core_closures(c, qd);
    for (int32_t k = 0; k < closures; k++) {
        memcpy(row_of(c, k), c->closure_jacobian + (size_t)k * (size_t)n, (size_t)n * sizeof(real));
        row_of(c, k)[n] = c->closure_bias[k];
    }
    for (; rank < closures; rank++) {
        int32_t row = 0, column = 0;
        const real pivot = find_pivot(c, dependent, rank, &row, &column);
        if (rank == 0) first = pivot;
        if (value_of(pivot) <= value_of(MIN_SHARE * first)) break;
        eliminate(c, rank, row, column);
        c->closure_order[rank] = column;
    }
    if (!closures) return 0;
    memset(c->free_motion, 0, (size_t)n * (size_t)n * sizeof(real));
    memset(c->free_bias, 0, (size_t)n * sizeof(real));
    for (int32_t j = 0; j < n; j++) c->free_motion[(size_t)j * (size_t)n + (size_t)j] = value_of(dependent[j]) == 0;
    for (int32_t s = 0; s < rank; s++) {
        const int32_t d = (int32_t)value_of(c->closure_order[s]);
        for (int32_t i = 0; i < n; i++)
            if (value_of(dependent[i]) == 0) c->free_motion[(size_t)d * (size_t)n + (size_t)i] = -row_of(c, s)[i];
        c->free_bias[d] = -row_of(c, s)[n];
    }
    for (int32_t j = 0; j < n; j++)
        if (value_of(dependent[j]) != 0 && !is_solved(c, rank, j)) return 1 + j;
    return 0;
}
