/* Linear programs for a sum of distances and for a maximum distance, solved by quadratic programs. */
#ifndef CARDSFLOW_LINEAR_H
#define CARDSFLOW_LINEAR_H

#include "dual_newton.h"

/* Lower and upper bounds of x. */
typedef struct {
    const real *low, *high;
} box;

/* Compute min max_i c_i |x_i - p_i| over the rows of a program, all hard, and bounds. If several solutions
   exist, return the x nearest to p. `first` satisfies rows and bounds. Cost and bounds of the program are
   overwritten. Return an enum dual_newton_status. */
DUAL_NEWTON_API int minimize_largest(dual_newton *s, box bounds, const real *c, const real *p, const real *first);

/* Do the same for sum_i c_i |x_i - p_i|, with positive c, and `parts` as working memory: a program with
   twice the variables and the same number of rows. */
DUAL_NEWTON_API int minimize_sum(dual_newton *s, dual_newton *parts, box bounds, const real *c, const real *p,
                                 const real *first);

#endif
