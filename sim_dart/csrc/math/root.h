/* The root of a function that changes its sign between two points. */
#ifndef CARDSFLOW_ROOT_H
#define CARDSFLOW_ROOT_H

#include "../numbers/real.h"

/* A function of z with some data, and its derivative. */
typedef real root_function(const void *data, real z, real *derivative);

/* Newton's rule, which goes twice as far if it is slow, and halves the bracket instead wherever it would
   leave it; bounded.
   g(high) >= 0; `low` itself if g is not negative there; `guess` between them. The last step is
   `enough` at most: what is left is about its square.                                                 */
CORE_INSIDE real bracketed_root(root_function *g, const void *data, real low, real high, real guess,
                                real enough);

#endif
