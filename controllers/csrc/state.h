/* The inside of a handle, and the small vector algebra.

   All work is done in scaled numbers, in which H is the identity and every row of A has length 1: then
   no unit and no scale of the caller's matters.
       x_i sqrt(H_i),   g_i / sqrt(H_i),   A_ji / (sqrt(H_i) norm_j),   b_j / norm_j,   y_j norm_j
   With lam the scaled multipliers, x(lam) = clip(A'lam - g, low, high), and what is left is
   r(lam) = b - eps lam - A x(lam) = 0, the gradient of a concave, piecewise quadratic function.        */
#ifndef CARDSFLOW_DUAL_NEWTON_STATE_H
#define CARDSFLOW_DUAL_NEWTON_STATE_H

#include "dual_newton.h"

#include <stdint.h>

/* Where a search meets a bound, and by how much the curvature along the search changes there. */
typedef struct breakpoint {
    double at, change;
} breakpoint;

/* ARRAY(type, name, number of elements) in the working memory behind the handle; every type has a
   multiple of 8 bytes.                                                                                */
#define STATE_ARRAYS(ARRAY)                                                                            \
    /* the problem, its start and its answer: see dual_newton_array */                                 \
    ARRAY(double, H_diagonal, n)                                                                       \
    ARRAY(double, g, n)                                                                                \
    ARRAY(double, lb, n)                                                                               \
    ARRAY(double, ub, n)                                                                               \
    ARRAY(double, A, n *m)                                                                             \
    ARRAY(double, b, m)                                                                                \
    ARRAY(double, softness, m)                                                                         \
    ARRAY(double, start, m)                                                                            \
    ARRAY(double, x, n)                                                                                \
    ARRAY(double, multipliers, m)                                                                      \
    ARRAY(double, slack, m)                                                                            \
    ARRAY(double, residuals, 2)                                                                        \
    /* the scaled problem */                                                                           \
    ARRAY(double, root, n) /* sqrt(H) */                                                               \
    ARRAY(double, norm, m) /* of a row of A */                                                         \
    ARRAY(double, sg, n)                                                                               \
    ARRAY(double, low, n)                                                                              \
    ARRAY(double, high, n)                                                                             \
    ARRAY(double, sA, n *m)                                                                            \
    ARRAY(double, sb, m)                                                                               \
    ARRAY(double, eps, m)                                                                              \
    /* the iterate */                                                                                  \
    ARRAY(double, lam, m)                                                                              \
    ARRAY(double, v, n)  /* A'lam - g */                                                               \
    ARRAY(double, sx, n) /* clip(v) */                                                                 \
    ARRAY(double, r, m)                                                                                \
    ARRAY(int64_t, side, n) /* of v: -1 at or below low, 1 at or above high, 0 between */              \
    /* a step */                                                                                       \
    ARRAY(double, centre, m)                                                                           \
    ARRAY(double, pull, m) /* r - ridge (lam - centre) */                                              \
    ARRAY(double, d, m)                                                                                \
    ARRAY(double, dv, n)                                                                               \
    ARRAY(double, factor, m *m)                                                                        \
    ARRAY(double, size, m)                                                                             \
    ARRAY(breakpoint, heap, 2 * n)                                                                     \
    /* the end, while it is refined */                                                                 \
    ARRAY(double, end_x, n)                                                                            \
    ARRAY(double, end_lam, m)                                                                          \
    ARRAY(double, rest, m)                                                                             \
    ARRAY(double, correction, m)

#define STATE_MEMBER(type, name, length) type *name;
struct dual_newton {
    size_t n, m;
    int64_t steps;
    STATE_ARRAYS(STATE_MEMBER)
};
#undef STATE_MEMBER

/* scale.c: the scaled problem from the caller's; an enum dual_newton_status. */
int scale_problem(dual_newton *s);

/* dual.c */
void dual_evaluate(dual_newton *s);                  /* v, sx, side and r at lam */
void dual_direction(dual_newton *s);                 /* dv = A'd */
void dual_rest(const dual_newton *s, const double *x, const double *lam, double *r, double *size);

/* factor.c: S = A_F A_F' + diag(eps + ridge) over the variables F between their bounds. */
void factor_build(dual_newton *s, double ridge);
void factor_solve(const dual_newton *s, const double *r, double *d);

/* search.c: how far to go from lam along d for the largest dual value, less ridge/2 |lam - centre|^2; far
   if it is beyond every bend.                                                                         */
double search_peak(dual_newton *s, double ridge, int *is_far);

/* settle.c: 1 if the bounds that the step began with are those of the optimum; then sx and lam are it. */
int settle(dual_newton *s);

/* certificate.c: 1 if y, cleared in soft rows, proves that no x fulfils the hard rows. */
int certificate_holds(const dual_newton *s, double *y);

/* The sum in four parts: a fixed order, and no chain of additions that wait for each other. */
static inline double dot(size_t count, const double *restrict a, const double *restrict b)
{
    double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
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

/* y += c x */
static inline void add(size_t count, double *restrict y, double c, const double *restrict x)
{
    for (size_t k = 0; k < count; k++) y[k] += c * x[k];
}

static inline double clip(double v, double low, double high)
{
    return v < low ? low : v > high ? high : v;
}

static inline double larger(double a, double b)
{
    return a > b ? a : b;
}

#endif
