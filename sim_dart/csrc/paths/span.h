/* Contribution of a straight span of a path to a row of L. */
#ifndef CARDSFLOW_SPAN_H
#define CARDSFLOW_SPAN_H

#include "../kinematics/points.h"

/* Only the motions between the two frames change the length of a span: those of ancestors of B move its end,
   those of ancestors of A its start. With u the direction from A to B, dl/dq_j = u.(dB/dq_j - dA/dq_j). */
static inline void add_span(const core *c, const real u[3], const real A[3], int32_t a, const real B[3],
                            int32_t b, real *row)
{
    real velocity[3];
    while (a != b) {
        if (b > a) {
            tree_point_velocity(c, b, B, velocity);
            row[c->blob.coordinate[b]] += dot3(u, velocity);
            b = c->blob.parent[b];
        } else {
            tree_point_velocity(c, a, A, velocity);
            row[c->blob.coordinate[a]] -= dot3(u, velocity);
            a = c->blob.parent[a];
        }
    }
}

/* The same as a function that is not inlined, for callers where speed matters less than code size. */
CORE_INSIDE void span_add(const core *c, const real u[3], const real A[3], int32_t a, const real B[3], int32_t b,
                          real *row);

#endif
