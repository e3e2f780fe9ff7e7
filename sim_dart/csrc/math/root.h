/* Root of a function that changes sign between two points. */
#ifndef CARDSFLOW_ROOT_H
#define CARDSFLOW_ROOT_H

#include "../numbers/real.h"

/* Return the value of a function of z with some data, and its derivative. */
typedef real root_function(const void *data, real z, real *derivative);

/* Return the root by Newton's method. Steps are doubled if convergence is slow, and replaced by bisection if
   they would leave the bracket; the number of steps is bounded.

   g(high) >= 0; the result is `low` if g is not negative there; `guess` is between both. The last step is
   `tolerance` at most: the remaining error is about its square. */
CORE_INSIDE real bracketed_root(root_function *g, const void *data, real low, real high, real guess,
                                real tolerance);

#endif
