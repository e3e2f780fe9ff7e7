/* The root of a function that changes its sign between two points. */
#ifndef CARDSFLOW_ROOT_H
#define CARDSFLOW_ROOT_H

/* A function of z with some data, and its derivative. */
typedef double root_function(const void *data, double z, double *derivative);

/* Newton's rule, which halves the bracket instead wherever it would leave it or is slow; bounded.
   g(high) >= 0; `low` itself if g is not negative there; `guess` between them. The last step is
   `enough` at most: what is left is about its square.                                                 */
double bracketed_root(root_function *g, const void *data, double low, double high, double guess,
                      double enough);

#endif
