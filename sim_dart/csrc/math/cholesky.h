/* Small symmetric systems. */
#ifndef CARDSFLOW_CHOLESKY_H
#define CARDSFLOW_CHOLESKY_H

#include "../numbers/real_functions.h"

#include <stddef.h>

static inline real cholesky_dot(size_t count, const real *a, const real *b)
{
    real sum = 0;
    for (size_t i = 0; i < count; i++) sum += a[i] * b[i];
    return sum;
}

/* Compute the Cholesky factor of a symmetric matrix, n x n. Return 0, or 1 if the matrix is not positive
   definite. */
static inline int cholesky_factor(size_t n, const real *A, real *factor)
{
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j <= i; j++) {
            const real sum = A[i * n + j] - cholesky_dot(j, factor + i * n, factor + j * n);
            if (i != j)
                factor[i * n + j] = sum / factor[j * n + j];
            else if (sum > 0)
                factor[i * n + i] = sqrt(sum);
            else
                return 1;
        }
    return 0;
}

/* Compute x <- A^-1 x. */
static inline void cholesky_solve(size_t n, const real *factor, real *x)
{
    for (size_t i = 0; i < n; i++) x[i] = (x[i] - cholesky_dot(i, factor + i * n, x)) / factor[i * n + i];
    for (size_t i = n; i-- > 0;) {
        for (size_t j = i + 1; j < n; j++) x[i] -= factor[j * n + i] * x[j];
        x[i] /= factor[i * n + i];
    }
}

#endif
