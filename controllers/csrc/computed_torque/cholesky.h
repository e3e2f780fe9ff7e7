/* Small symmetric systems. */
#ifndef CARDSFLOW_CHOLESKY_H
#define CARDSFLOW_CHOLESKY_H

#include "../../../sim_dart/csrc/numbers/real.h"

#include <stddef.h>

/* Cholesky's factor of a symmetric positive definite matrix, n x n: 0, or 1 if it is not. */
int cholesky_factor(size_t n, const real *A, real *factor);
/* x <- A^-1 x */
void cholesky_solve(size_t n, const real *factor, real *x);

#endif
