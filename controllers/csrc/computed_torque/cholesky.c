#include "cholesky.h"

#include "../dual_newton/vectors.h"

#include <math.h>

int cholesky_factor(size_t n, const real *A, real *factor)
{
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j <= i; j++) {
            const real sum = A[i * n + j] - dot(j, factor + i * n, factor + j * n);
            if (i != j)
                factor[i * n + j] = sum / factor[j * n + j];
            else if (sum > 0)
                factor[i * n + i] = sqrt(sum);
            else
                return 1;
        }
    return 0;
}

void cholesky_solve(size_t n, const real *factor, real *x)
{
    for (size_t i = 0; i < n; i++) x[i] = (x[i] - dot(i, factor + i * n, x)) / factor[i * n + i];
    for (size_t i = n; i-- > 0;) {
        for (size_t j = i + 1; j < n; j++) x[i] -= factor[j * n + i] * x[j];
        x[i] /= factor[i * n + i];
    }
}
