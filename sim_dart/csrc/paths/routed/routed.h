/* Muscles with more than fixed points and taut wraps. */
#ifndef CARDSFLOW_ROUTED_H
#define CARDSFLOW_ROUTED_H

#include "../../blob/state.h"

/* Indices into the lists of the blob during the iteration over all paths. */
typedef struct {
    int32_t wrap, lane, pulley, condition, move, branch, term;
} progress;

CORE_INSIDE void routed_prepare(core *c);
/* Compute the positions of points that move on their links. */
CORE_INSIDE void routed_place(core *c);
/* Add the length of a muscle and its row of L. `at` is advanced past the muscle, whose first via point is
   `first`. */
CORE_INSIDE real routed_add(core *c, int32_t m, int32_t first, progress *at, real *row, int is_traced);

#endif
