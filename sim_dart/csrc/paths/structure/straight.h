/* Straight segments of paths. */
#ifndef CARDSFLOW_STRAIGHT_H
#define CARDSFLOW_STRAIGHT_H

#include "../span.h"

/* Add the segment from via point k to the next one, as a straight line. */
static inline real add_segment(const core *c, int32_t k, real *row)
{
    const real *A = c->point + 3 * k, *B = A + 3;
    real u[3] = {B[0] - A[0], B[1] - A[1], B[2] - A[2]};
    const real length = sqrt(dot3(u, u));
    if (is_rare(c, length == 0)) return number(0); /* no direction, so no moment arm */
    for (int j = 0; j < 3; j++) u[j] /= length;
    add_span(c, u, A, c->blob.point_frame[k], B, c->blob.point_frame[k + 1], row);
    return length;
}

/* Return whether all paths of a robot consist of straight segments between points that are fixed to frames. */
CORE_INSIDE int straight_applies(const core *c);
/* Compute the via points in the world. */
CORE_INSIDE void straight_place(core *c);
/* Do the same as paths_move, for such a robot. */
CORE_INSIDE void straight_move(core *c);

#endif
