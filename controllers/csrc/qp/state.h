/* Internal state of a handle.

   All computations use scaled numbers, in which H is the identity and every row of A has length 1, so that
   units and scales of the caller are irrelevant:

     x_i sqrt(H_i),   g_i / sqrt(H_i),   A_ji / (sqrt(H_i) norm_j),   b_j / norm_j,   y_j norm_j

   With lam the scaled multipliers, x(lam) = clip(A'lam - g, low, high), and the residual r(lam) = b - eps
   lam - A x(lam) = 0 is the gradient of a concave, piecewise quadratic function. */
#ifndef CARDSFLOW_DUAL_NEWTON_STATE_H
#define CARDSFLOW_DUAL_NEWTON_STATE_H

#include "dual_newton.h"
#include "../../../sim_dart/csrc/math/rows.h"

#include <stdint.h>

/* Point on the search line at which a variable reaches a bound, and the change of the curvature there. */
typedef struct breakpoint {
    real at, change;
} breakpoint;

/* ARRAY(type, name, number of elements) in the working memory after the handle. The size of every type is a
   multiple of the size of a real, and its alignment is not larger. */
#define STATE_ARRAYS(ARRAY)                                                                            \
    /* the problem, its start and its answer: see dual_newton_array */                                 \
    ARRAY(real, H_diagonal, n)                                                                         \
    ARRAY(real, g, n)                                                                                  \
    ARRAY(real, lb, n)                                                                                 \
    ARRAY(real, ub, n)                                                                                 \
    ARRAY(real, A, n *m)                                                                               \
    ARRAY(real, b, m)                                                                                  \
    ARRAY(real, softness, m)                                                                           \
    ARRAY(real, start, m)                                                                              \
    ARRAY(real, x, n)                                                                                  \
    ARRAY(real, multipliers, m)                                                                        \
    ARRAY(real, slack, m)                                                                              \
    ARRAY(real, residuals, 2)                                                                          \
    /* the scaled problem */                                                                           \
    ARRAY(real, root, n) /* sqrt(H) */                                                                 \
    ARRAY(real, norm, m) /* of a row of A */                                                           \
    ARRAY(real, sg, n)                                                                                 \
    ARRAY(real, low, n)                                                                                \
    ARRAY(real, high, n)                                                                               \
    ARRAY(real, sA, n *m)                                                                              \
    ARRAY(real, sb, m)                                                                                 \
    ARRAY(real, eps, m)                                                                                \
    /* the iterate */                                                                                  \
    ARRAY(real, lam, m)                                                                                \
    ARRAY(real, v, n)  /* A'lam - g */                                                                 \
    ARRAY(real, sx, n) /* clip(v) */                                                                   \
    ARRAY(real, r, m)                                                                                  \
    ARRAY(whole_number, side, n) /* of v: -1 at or below low, 1 at or above high, 0 between */         \
    /* a step */                                                                                       \
    ARRAY(real, d, m)                                                                                  \
    ARRAY(real, dv, n)                                                                                 \
    ARRAY(real, factor, m *m)                                                                          \
    ARRAY(real, pivot, m) /* the smallest ones that are not rounding errors */                         \
    ARRAY(real, size, m)                                                                               \
    ARRAY(breakpoint, heap, 2 * n)                                                                     \
    /* of the interior point method: see interior.c */                                                 \
    ARRAY(real, low_gap, n)                                                                            \
    ARRAY(real, high_gap, n)                                                                           \
    ARRAY(real, low_push, n)                                                                           \
    ARRAY(real, high_push, n)                                                                          \
    ARRAY(real, low_change, n)                                                                         \
    ARRAY(real, high_change, n)                                                                        \
    ARRAY(real, weight, n)                                                                             \
    ARRAY(real, goal, n)                                                                               \
    ARRAY(real, inner_x, n)                                                                            \
    ARRAY(real, dx, n)                                                                                 \
    /* the final computation */                                                                        \
    ARRAY(real, end_x, n)                                                                              \
    ARRAY(real, end_lam, m)                                                                            \
    ARRAY(real, rest, m)                                                                               \
    ARRAY(real, correction, m)

#define STATE_MEMBER(type, name, length) type *name;
struct dual_newton {
    size_t n, m;
    int64_t steps;
    STATE_ARRAYS(STATE_MEMBER)
};
#undef STATE_MEMBER

/* scale.c: compute the scaled problem from the inputs. Return an enum dual_newton_status. */
int scale_problem(dual_newton *s);

/* dual.c */
void dual_evaluate(dual_newton *s);                  /* v, sx, side and r at lam */
void dual_direction(dual_newton *s);                 /* dv = A'd */
void dual_residual(const dual_newton *s, const real *x, const real *lam, real *r, real *size);

/* factor.c: compute S = A_F A_F' + diag(eps + ridge) over the variables F between their bounds. */
void factor_build(dual_newton *s, real ridge);
/* Compute S = A diag(weight) A' + diag(rows), with its diagonal raised by a share of itself. */
void factor_weighted(dual_newton *s, const real *rows, real ridge);
void factor_solve(const dual_newton *s, const real *r, real *d);

/* search.c: return the step from lam along d to the maximum of the dual function minus ridge/2 |t d|^2.
   `is_far`: it is beyond every breakpoint. */
real search_peak(dual_newton *s, real ridge, int *is_far);

/* polish.c: return 1 if the active bounds at the start of the step are those of the optimum; then sx and lam
   are the optimum, and no residual of a row exceeds the tolerance, relative to its terms. */
int polish(dual_newton *s, real tolerance);
/* Do the same for the bounds in `side`, with sx and lam for cases that the bounds alone do not determine. */
int polish_at_bounds(dual_newton *s, real tolerance);
/* Do the same for sx and lam. */
int polish_here(dual_newton *s, real tolerance);
/* Compute the residuals of sx and lam; they are made finite. */
void measure(dual_newton *s);

/* certificate.c: return 1 if y, set to zero in soft rows and for unbounded variables, proves that the hard
   rows are infeasible. The proof is stored in s->correction. */
int is_proof(dual_newton *s, const real *y);

/* interior.c: return an enum dual_newton_status. */
int interior_point(dual_newton *s);

#endif
