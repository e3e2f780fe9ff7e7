/* Quadratic programs over stages, of optimal control:

     min sum_k 1/2 v_k' H_k v_k + g_k' v_k + penalties     v_k = (u_k, x_k), k < N;  v_N = x_N
     s.t. x_k+1 = C_k v_k + c_k,   low <= v <= high,   x_0 = start

   A bound with a positive penalty p is soft: a violation e costs p e.

   The solver is the primal-dual interior-point method of Mehrotra; a backward recursion of Riccati solves
   its linear systems in a time proportional to N: C. V. Rao, S. J. Wright, J. B. Rawlings, Application of
   interior-point methods to model predictive control, J. Optim. Theory Appl. 99, 1998.

   The solver does not allocate memory, has no global state and no I/O: the caller owns the memory. */
#ifndef CARDSFLOW_STAGE_QP_H
#define CARDSFLOW_STAGE_QP_H

#include "../core.h" /* CORE_API */

typedef struct stage_qp stage_qp;

enum stage_qp_status {
    STAGE_QP_SOLVED = 0,
    STAGE_QP_NOT_CONVERGED = 1, /* the maximum number of iterations was reached; v is the last iterate */
    STAGE_QP_FAILED = 2         /* the cost is not convex, or a number is not finite */
};

/* Return the size of the working memory in bytes for N >= 1 stages, and numbers of states and controls. */
CORE_API size_t stage_qp_size(int stages, int states, int controls);

/* Create a handle in `memory`, which is 8-byte aligned; this call sets it to zero, without bounds. */
CORE_API stage_qp *stage_qp_open(int stages, int states, int controls, void *memory);

/* Return an array by name, and its length; NULL if it does not exist. w = controls + states; t = N w + states
   is the number of variables, in the order v_0, ..., v_N.

     H            upper triangles: N of w x w, then one of states x states
     g            t
     C, c         N x states x w; N x states
     low, high    t; infinite without a bound. Those of x_0 are not used
     penalty      t, of both bounds of a variable; 0 for hard bounds
     start        states
     tolerance    2: of the complementarity t z of bounds; of the rest of the initial residuals, relative
     v            t: start of the iterations, and solution */
CORE_API real *stage_qp_array(stage_qp *s, const char *name, size_t *length);

/* Solve the program: begin at v, then iterate while the status is STAGE_QP_NOT_CONVERGED, up to a limit of the
   caller. Return an enum stage_qp_status. */
CORE_API int stage_qp_begin(stage_qp *s);
CORE_API int stage_qp_iterate(stage_qp *s);

/* Return the number of iterations of the last solution. */
CORE_API int stage_qp_iterations(const stage_qp *s);

#endif
