/* Algebra of rows of numbers. */
#ifndef CARDSFLOW_ROWS_H
#define CARDSFLOW_ROWS_H

#include "elementary.h"

#include <stddef.h>

/* Return the dot product, summed in four parts: the order is fixed, and additions do not wait for each
   other. */
static inline real dot(size_t count, const real *restrict a, const real *restrict b)
{
    real s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    size_t k = 0;
    for (; k + 4 <= count; k += 4) {
        s0 += a[k] * b[k];
        s1 += a[k + 1] * b[k + 1];
        s2 += a[k + 2] * b[k + 2];
        s3 += a[k + 3] * b[k + 3];
    }
    for (; k < count; k++) s0 += a[k] * b[k];
    return (s0 + s1) + (s2 + s3);
}

/* Compute y += c x. */
static inline void add(size_t count, real *restrict y, real c, const real *restrict x)
{
    for (size_t k = 0; k < count; k++) y[k] += c * x[k];
}

static inline real clip(real v, real low, real high)
{
    return v < low ? low : v > high ? high : v;
}

#endif
