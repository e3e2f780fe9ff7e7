/* Muscles whose path is more than fixed points and wraps by our own rules. */
#ifndef CARDSFLOW_ROUTED_H
#define CARDSFLOW_ROUTED_H

#include "../../blob/state.h"

/* How far the walk along all paths has come in the lists of the blob. */
typedef struct {
    int32_t wrap, pulley, condition, move, branch, term;
} progress;

CORE_INSIDE void routed_prepare(core *c);
/* Put the points that move on their links. */
CORE_INSIDE void routed_place(core *c);
/* A muscle's length, and its row of L; `at` is moved past it, whose first via point is `first`. */
CORE_INSIDE real routed_add(core *c, int32_t m, int32_t first, progress *at, real *row, int is_traced);

#endif
