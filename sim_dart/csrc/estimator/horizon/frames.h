/* Moving horizon of an estimator: the states of the last K measurements, the frames, minimise

     1/2 (x_1 - a)' P^-1 (x_1 - a) + sum_k 1/2 v_k' Q_k^-1 v_k + sum_k,i loss_i(z_ki - h_i(x_k))
     s.t.  x_k+1 = F(x_k) + v_k,   low <= q_k <= high

   The loss of a measurement with standard deviation s is r^2/2 for |r| <= huber s, and then grows linearly
   (Huber 1964), both over s^2. The length of a slack muscle is not below l(q): its loss is 0 for r >= 0. Before
   the first frame, all measurements are contained in a and P: those of the Kalman filter.

   Joint limits stop a coordinate by an unknown impact: Q_k contains an impulse along coordinates that may have
   reached a bound.

   A measurement is ignored if its residual exceeds `gate` standard deviations at the solution, which is tested
   again in each tick: unlike the prediction of a filter, the solution follows the majority of measurements.

   In each tick all frames are linearised about the last solution, and a convex program is solved: see window.h. */
#ifndef CARDSFLOW_HORIZON_FRAMES_H
#define CARDSFLOW_HORIZON_FRAMES_H

#include "../state.h"

/* ARRAY(name, number of reals). B measurements and T terms in a frame; a term is a measurement or a bound. */
#define HORIZON_SETTINGS(ARRAY) \
    ARRAY(huber, 1)             \
    ARRAY(low, n)               \
    ARRAY(high, n)
#define HORIZON_REMEMBERED(ARRAY)                                          \
    ARRAY(frames, 1)    /* number of frames until now */                   \
    ARRAY(has_arrival, 1)                                                  \
    ARRAY(iterations, 1)                                                   \
    ARRAY(arrival, N)   /* a */                                            \
    ARRAY(arrival_covariance, N *N)                                        \
    ARRAY(next_arrival, N) /* for the second frame */                      \
    ARRAY(next_covariance, N *N)                                           \
    ARRAY(before, N)    /* state before the first frame */                 \
    ARRAY(slips_before, bends)
/* For each frame. */
#define HORIZON_FRAMES(ARRAY)                                              \
    ARRAY(x, N)                                                            \
    ARRAY(slips, bends)                                                    \
    ARRAY(forces, m)    /* last_tensions */                                \
    ARRAY(inputs, B)    /* lengths to accelerometer*/                          \
    ARRAY(clock, 2)     /* h and number of steps before the frame */       \
    ARRAY(multiplier, B + 2 * n)
/* Working memory for each frame. */
#define HORIZON_WORK(ARRAY)                                                \
    ARRAY(A, 6 * n * n) /* see estimator_propagate */                      \
    ARRAY(Q, N *N)                                                         \
    ARRAY(defect, N)    /* F(x of the last frame) - x */                   \
    ARRAY(shift, N)     /* change of x */                                  \
    ARRAY(adjoint, N)   /* multiplier of the dynamics */                   \
    ARRAY(count, 1)     /* number of terms; for each term: */              \
    ARRAY(slot, T)      /* index of its multiplier */                      \
    ARRAY(row, T * 3 * n) /* derivatives by q, qd, w */                    \
    ARRAY(residual, T)  /* at x */                                         \
    ARRAY(variance, T)                                                     \
    ARRAY(least, T)     /* bounds of its multiplier */                     \
    ARRAY(most, T)                                                         \
    ARRAY(rest, T)      /* residual at x + shift */                        \
    ARRAY(last_rest, T) /* the same before a step */                       \
    ARRAY(last, T)      /* multiplier before a step */                     \
    ARRAY(step, T)      /* of the multiplier */                            \
    ARRAY(is_free, T)   /* whether the multiplier is within its bounds */  \
    ARRAY(gain, T *N)                                                      \
    ARRAY(innovation, T)                                                   \
    ARRAY(spread, T)    /* variance of the innovation */

#define HORIZON_MEMBERS(name_, length) \
    real *name_;                       \
    size_t name_##_length;
typedef struct horizon {
    size_t K, B, T, remembered;
    HORIZON_SETTINGS(NAMED_MEMBER)
    HORIZON_REMEMBERED(NAMED_MEMBER)
    HORIZON_FRAMES(HORIZON_MEMBERS)
    HORIZON_WORK(HORIZON_MEMBERS)
    real *P, *mean;      /* working memory, N x N and N */
    real *current;       /* inputs of the current tick */
} horizon;
#undef HORIZON_MEMBERS

/* Return an array by name, see estimator_array; NULL without a horizon. */
real *horizon_array(estimator *e, const char *name, size_t *length);

/* Return whether coordinate j moves towards one of its bounds and may have reached it. */
static inline int horizon_approaches_bound(const estimator *e, size_t j)
{
    const real q = e->state[j], qd = e->state[e->n + j], margin = 3 * e->sd[j];
    return (qd > 0 && q + margin >= e->horizon->high[j]) || (qd < 0 && q - margin <= e->horizon->low[j]);
}

/* Return the index of the bias of a term, or N. */
static inline size_t bias_of(const estimator *e, size_t slot)
{
    const size_t first = 2 * e->m + 2 * e->n, k = slot - first;
    if (slot < e->m) return offset_state(e, slot);
    if (slot < first || k >= 6 * e->i) return e->N;
    const size_t is_force = k >= 3 * e->i, axis = is_force ? k - 3 * e->i : k;
    return 3 * e->n + axis / 3 * 6 + 3 * is_force + axis % 3;
}

#endif
