/* Linear programs of a sum of distances and of a largest distance, by quadratic ones. */
#ifndef CARDSFLOW_LINEAR_H
#define CARDSFLOW_LINEAR_H

#include "dual_newton.h"

/* Lower and upper bounds of x. */
typedef struct {
    const real *low, *high;
} box;

/* min max_i c_i |x_i - p_i| over the rows of a program, all hard, and bounds. Of several answers x is the one
   nearest to p. `first` fulfils rows and bounds. Cost and bounds of the program are overwritten. An enum
   dual_newton_status.                                                                                  */
DUAL_NEWTON_API int least_largest(dual_newton *s, box bounds, const real *c, const real *p, const real *first);

/* The same of sum_i c_i |x_i - p_i|, c positive, with working memory: a program of twice the variables and as
   many rows.                                                                                           */
DUAL_NEWTON_API int least_sum(dual_newton *s, dual_newton *parts, box bounds, const real *c, const real *p,
                              const real *first);

#endif
