/* Quadratic programs with a diagonal cost, equalities that may be soft, and bounds:

     min 1/2 x'Hx + g'x + 1/2 sum_j s_j^2/softness_j   s.t.   A x - s = b,   lb <= x <= ub

   solved by a semismooth Newton method on the multipliers of the rows.

   The solver does not allocate memory, has no global state and no I/O: the caller owns the working memory.
   Every function of one handle must be called from one thread at a time. */
#ifndef CARDSFLOW_DUAL_NEWTON_H
#define CARDSFLOW_DUAL_NEWTON_H

#include "../../../sim_dart/csrc/numbers/real.h"

#include <stddef.h>

#if defined(CARDSFLOW_INSIDE) /* defined in another library */
#define DUAL_NEWTON_API
#elif defined(_WIN32)
#define DUAL_NEWTON_API __declspec(dllexport)
#else
#define DUAL_NEWTON_API __attribute__((visibility("default")))
#endif

typedef struct dual_newton dual_newton;

enum dual_newton_status {
    DUAL_NEWTON_SOLVED = 0,        /* x is the optimum; the residuals were checked */
    DUAL_NEWTON_INFEASIBLE = 1,    /* the hard rows are infeasible; `multipliers` prove it */
    DUAL_NEWTON_NOT_CONVERGED = 2, /* neither of both was proven */
    DUAL_NEWTON_WRONG_COST = 3,    /* an entry of H is not positive, or H or g is not finite */
    DUAL_NEWTON_WRONG_BOUNDS = 4,  /* lb is above ub, or a bound is NaN or infinite on the wrong side */
    DUAL_NEWTON_WRONG_ROWS = 5     /* A or b is not finite or too large, or a softness negative */
};

#define DUAL_NEWTON_LARGEST_SIZE 4096

/* Return the size of the working memory in bytes; 0 if a size is not within 1 to its maximum. */
DUAL_NEWTON_API size_t dual_newton_size(int variables, int rows);

/* Create a handle in `memory`, which is 8-byte aligned and has dual_newton_size bytes; this call sets it to
   zero. Return NULL if the memory or a size is rejected. */
DUAL_NEWTON_API dual_newton *dual_newton_open(int variables, int rows, void *memory);

/* Return an array by name, and its number of elements; NULL if the array does not exist.

   To be written:
     H_diagonal, g, lb, ub   variables; lb and ub may be infinite, or equal
     A                       variables x rows: the coefficients, variable after variable
     b, softness             rows; a softness of 0 makes a row hard
     start                   rows: initial multipliers; overwritten with the solution
   Results:
     x                       variables
     multipliers             rows: y with H x + g - A'y = 0 for variables not at bounds, s_j = -softness_j y_j;
                             for an infeasible problem a proof: y'b > y'A x for all x within bounds
     slack                   rows: A x - b
     residuals               2: of the rows, and of the dual, relative to the sum of the absolute terms */
DUAL_NEWTON_API real *dual_newton_array(dual_newton *s, const char *name, size_t *length);

/* Solve the problem in the arrays, in 84 steps at most. Return an enum dual_newton_status. */
DUAL_NEWTON_API int dual_newton_solve(dual_newton *s);

/* Return the number of Newton steps of the last call. */
DUAL_NEWTON_API int dual_newton_steps(const dual_newton *s);

#endif
