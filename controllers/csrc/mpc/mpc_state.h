/* Internal state of model predictive control. */
#ifndef CARDSFLOW_MPC_STATE_H
#define CARDSFLOW_MPC_STATE_H

#include "../../../sim_dart/csrc/math/rows.h"
#include "../../../sim_dart/csrc/named_arrays.h"
#include "mpc.h"

/* ARRAY(name, number of elements): first those of mpc_array. */
#define MPC_ARRAYS(ARRAY)                                                                              \
    ARRAY(horizon, 1)                                                                                  \
    ARRAY(period, 1)                                                                                   \
    ARRAY(iterations, 1)                                                                               \
    ARRAY(tolerance, 1)                                                                                \
    ARRAY(deadline, 1)                                                                                 \
    ARRAY(tracking, r)                                                                                 \
    ARRAY(tracking_rates, r)                                                                           \
    ARRAY(accelerations, r)                                                                            \
    ARRAY(posture, n)                                                                                  \
    ARRAY(posture_rates, n)                                                                            \
    ARRAY(posture_accelerations, n)                                                                    \
    ARRAY(q0, n)                                                                                       \
    ARRAY(speeds, n)                                                                                   \
    ARRAY(forces_cost, a)                                                                              \
    ARRAY(force_rates, a)                                                                              \
    ARRAY(f_p, a)                                                                                      \
    ARRAY(f_min, a)                                                                                    \
    ARRAY(f_max, a)                                                                                    \
    ARRAY(first_min, a)                                                                                \
    ARRAY(first_max, a)                                                                                \
    ARRAY(plan_min, a)                                                                                 \
    ARRAY(plan_max, a)                                                                                 \
    ARRAY(q_min, n)                                                                                    \
    ARRAY(q_max, n)                                                                                    \
    ARRAY(qd_max, n)                                                                                   \
    ARRAY(limit_penalty, n)                                                                            \
    ARRAY(used, 1)                                                                                     \
    ARRAY(is_late, 1)                                                                                  \
    ARRAY(planned, 1)            /* then x and f */                                                    \
    ARRAY(x, (N + 1) * 2 * n)                                                                          \
    ARRAY(f, N *a)                                                                                     \
    ARRAY(before, a)             /* the forces of the last tick */                                     \
    ARRAY(h, N)                  /* lengths of the intervals */                                        \
    ARRAY(ends, N * 2 * n)                                                                             \
    ARRAY(error, (N + 1) * r)    /* position minus reference at the nodes, and its rate */             \
    ARRAY(rate, (N + 1) * r)                                                                           \
    ARRAY(J, (N + 1) * r * n)    /* of the followed coordinates */                                     \
    ARRAY(null, (N + 1) * n * n) /* projections on motions without motion of the tasks, symmetric */   \
    ARRAY(JJ, 2 * r *r)                                                                                \
    ARRAY(bias, r)                                                                                     \
    ARRAY(reference, 3 * r)                                                                            \
    ARRAY(row, a + 2 * n)

/* Arrays of the program, see stage_qp_array; v are the changes of forces and states. */
#define QP_ARRAYS(ARRAY)                                                                               \
    ARRAY(H) ARRAY(g) ARRAY(C) ARRAY(c) ARRAY(low) ARRAY(high) ARRAY(penalty) ARRAY(tolerance) ARRAY(v)

#define QP_MEMBER(name) real *name;
struct mpc {
    mpc_model model;
    size_t n, a, r, N;
    int has_tasks;
    double begun, looked, longest; /* begin of the tick; last reading of the clock; longest time between two */
    stage_qp *program;
    struct {
        QP_ARRAYS(QP_MEMBER)
    } qp;
    MPC_ARRAYS(NAMED_MEMBER)
};
#undef QP_MEMBER

/* Return the share of a node in an integral over time. */
static inline real mpc_share(const mpc *s, size_t k)
{
    return ((k ? s->h[k - 1] : 0) + (k < s->N ? s->h[k] : 0)) / 2;
}

/* Return the index of the first state of node k in the variables of the program. */
static inline size_t mpc_states(const mpc *s, size_t k)
{
    return k * (s->a + 2 * s->n) + (k < s->N ? s->a : 0);
}

#endif
