/* The motion equation in independent coordinates: with qdd = N qdd_I + c of free_motion.c and J N = 0, N'
   eliminates the constraint forces J'p from M qdd + h = -L'f + J'p:

     N'M N qdd_I + N'(h + M c) = -(L N)'f.

   The terms keep the dimensions of the robot. */
#include "../core.h"

#include "../blob/state.h"

#include <string.h>

static real dot(int32_t n, const real *a, const real *b)
{
    real sum = 0;
    for (int32_t j = 0; j < n; j++) sum += a[j] * b[j];
    return sum;
}

void core_independent_rows(core *c, int32_t count, real *rows)
{
    const int32_t n = c->blob.counts.dofs;
    if (!c->blob.counts.closures) return;
    for (real *row = rows; count-- > 0; row += n) {
        memcpy(c->free_row, row, (size_t)n * sizeof(real));
        memset(row, 0, (size_t)n * sizeof(real));
        for (int32_t k = 0; k < n; k++)
            for (int32_t j = 0; j < n; j++) row[j] += c->free_row[k] * c->free_motion[(size_t)k * (size_t)n + (size_t)j];
    }
}

void core_independent_bias(core *c, int32_t count, const real *rows, real *values)
{
    const int32_t n = c->blob.counts.dofs;
    if (!c->blob.counts.closures) return;
    for (int32_t i = 0; i < count; i++) values[i] += dot(n, rows + (size_t)i * (size_t)n, c->free_bias);
}

void core_independent_mass(core *c, const real *dependent, real *M)
{
    const size_t n = (size_t)c->blob.counts.dofs;
    if (!c->blob.counts.closures) return;
    core_independent_rows(c, (int32_t)n, M); /* M N */
    for (size_t j = 0; j < n; j++)
        for (size_t k = 0; k < n; k++) c->free_matrix[k * n + j] = M[j * n + k];
    memcpy(M, c->free_matrix, n * n * sizeof(real));
    core_independent_rows(c, (int32_t)n, M); /* N'M N, as M is symmetric */
    for (size_t k = 0; k < n; k++)
        if (value_of(dependent[k]) != 0) M[k * n + k] = 1;
}

void core_complete(core *c, real *qdd)
{
    const int32_t n = c->blob.counts.dofs;
    if (!c->blob.counts.closures) return;
    memcpy(c->free_row, qdd, (size_t)n * sizeof(real));
    for (int32_t j = 0; j < n; j++)
        qdd[j] = dot(n, c->free_motion + (size_t)j * (size_t)n, c->free_row) + c->free_bias[j];
}
