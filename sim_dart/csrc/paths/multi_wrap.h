/* A cable over several surfaces in one segment. */
#ifndef CARDSFLOW_MULTI_WRAP_H
#define CARDSFLOW_MULTI_WRAP_H

#include "cable.h"

/* A part of a sequence: a surface, or a pulley, which can only be the first part. */
typedef struct {
    const wrap_surface *surface; /* NULL: a pulley */
    wrap_way way;
    real v[3], radius; /* of a pulley */
} sequence_part;

/* Compute the taut cable from `points[0]` to `points[count]` over the parts in order. Between two parts it
   passes one of the other points, which this function computes. */
CORE_INSIDE real sequence_solve(const sequence_part *parts, int count, real (*points)[3], contact *contacts);

#endif
