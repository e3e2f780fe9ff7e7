/* Internal state of a program over stages. */
#ifndef CARDSFLOW_STAGE_STATE_H
#define CARDSFLOW_STAGE_STATE_H

#include "../math/rows.h"
#include "../named_arrays.h"
#include "stage_qp.h"

/* ARRAY(name, number of elements): first those of stage_qp_array. Arrays of bounds have two sides. */
#define STAGE_ARRAYS(ARRAY)                                                                            \
    ARRAY(H, N *w *w + x * x)                                                                          \
    ARRAY(g, total)                                                                                    \
    ARRAY(C, N *x *w)                                                                                  \
    ARRAY(c, N *x)                                                                                     \
    ARRAY(low, total)                                                                                  \
    ARRAY(high, total)                                                                                 \
    ARRAY(penalty, total)                                                                              \
    ARRAY(start, x)                                                                                    \
    ARRAY(tolerance, 2)                                                                                \
    ARRAY(v, total)                                                                                    \
    ARRAY(step, total)         /* of v */                                                              \
    ARRAY(slope, total)        /* H v + g */                                                           \
    ARRAY(defect, (N + 1) * x) /* start - x_0; C v + c - x of the next stage */                        \
    ARRAY(diagonal, total)     /* terms of the bounds in H and g */                                    \
    ARRAY(force, total)                                                                                \
    ARRAY(slack, 2 * total)    /* t > 0 and e > 0, and their multipliers */                            \
    ARRAY(excess, 2 * total)                                                                           \
    ARRAY(z, 2 * total)                                                                                \
    ARRAY(l, 2 * total)                                                                                \
    ARRAY(second_z, 2 * total) /* products of the steps of the predictor */                            \
    ARRAY(second_l, 2 * total)                                                                         \
    ARRAY(factor, N *u *w)     /* rows of the Cholesky factors */                                      \
    ARRAY(P, (N + 1) * x * x)  /* Hessians of the costs to go, symmetric */                            \
    ARRAY(PC, x *w)                                                                                    \
    ARRAY(F, w *w)                                                                                     \
    ARRAY(Pc, x)                                                                                       \
    ARRAY(f, total)

struct stage_qp {
    size_t N, x, u, w, total;
    int steps;
    real gap, rest; /* complementarity; share of the initial residuals of the linear conditions that remains */
    STAGE_ARRAYS(NAMED_MEMBER)
};

/* Return the index of the first variable of x_k in v. */
static inline size_t stage_states(const stage_qp *s, size_t k)
{
    return k * s->w + (k < s->N ? s->u : 0);
}

#endif
