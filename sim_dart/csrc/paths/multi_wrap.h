/* A cable over several surfaces in one segment. */
#ifndef CARDSFLOW_MULTI_WRAP_H
#define CARDSFLOW_MULTI_WRAP_H

#include "cable.h"

/* One part of a sequence: a pulley, which can only be the first, or a surface. */
typedef struct {
    const wrap_surface *surface; /* NULL: a pulley */
    wrap_way way;
    real v[3], radius; /* of a pulley */
} sequence_part;

/* The taut cable from `points[0]` to `points[count]` over parts in order; between two of them it passes
   one of the other points, which this finds.                                                          */
CORE_INSIDE real sequence_solve(const sequence_part *parts, int count, real (*points)[3], contact *contacts);

#endif
