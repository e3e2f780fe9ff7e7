/* Internal state of a control loop. */
#ifndef CARDSFLOW_LOOP_STATE_H
#define CARDSFLOW_LOOP_STATE_H

#include "../laws/torque_state.h"
#include "control_loop.h"

/* ARRAY(name, number of elements); the arrays from acting to seen_load form the internal state. */
#define LOOP_ARRAYS(ARRAY)                                                                             \
    ARRAY(ki, r)                                                                                       \
    ARRAY(gain, 1)                                                                                     \
    ARRAY(midpoint, 1)                                                                                 \
    ARRAY(delay, 1)                                                                                    \
    ARRAY(predict, 1)                                                                                  \
    ARRAY(acting, m)                                                                                   \
    ARRAY(coming, m)                                                                                   \
    ARRAY(correction, r)                                                                               \
    ARRAY(disturbance, n)                                                                              \
    ARRAY(has_seen, 1)                                                                                 \
    ARRAY(seen_q, n)                                                                                   \
    ARRAY(seen_qd, n)                                                                                  \
    ARRAY(seen_forces, m)                                                                              \
    ARRAY(seen_load, n)                                                                                \
    ARRAY(load, n)                                                                                     \
    ARRAY(later, n)                                                                                    \
    ARRAY(faster, n)                                                                                   \
    ARRAY(half_way, n)                                                                                 \
    ARRAY(qdd, n)                                                                                      \
    ARRAY(ahead, 3 * r) /* the reference when forces take effect */

struct control_loop {
    control_robot robot;
    control_law custom;
    computed_torque *law;
    LOOP_ARRAYS(NAMED_MEMBER)
};

/* Compute M, h and L of the robot at a state, in the arrays of the law. */
static inline void loop_terms(control_loop *s, const real *q, const real *qd)
{
    s->robot.terms(s->robot.self, q, qd, s->law->M, s->law->h, s->law->L);
}

#endif
