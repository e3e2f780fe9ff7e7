/* Internal state of a computed-torque handle. */
#ifndef CARDSFLOW_COMPUTED_TORQUE_STATE_H
#define CARDSFLOW_COMPUTED_TORQUE_STATE_H

#include "../../../sim_dart/csrc/named_arrays.h"
#include "../qp/state.h"
#include "computed_torque.h"

/* ARRAY(name, number of elements): first the arrays of computed_torque_array. */
#define TORQUE_ARRAYS(ARRAY)                                                                           \
    ARRAY(M, n *n)                                                                                     \
    ARRAY(h, n)                                                                                        \
    ARRAY(G, n)                                                                                        \
    ARRAY(load, n)                                                                                     \
    ARRAY(L, m *n)                                                                                     \
    ARRAY(error, r)                                                                                    \
    ARRAY(rate_error, r)                                                                               \
    ARRAY(acceleration, r)                                                                             \
    ARRAY(correction, r)                                                                               \
    ARRAY(q, n)                                                                                        \
    ARRAY(qd, n)                                                                                       \
    ARRAY(J, k *n)                                                                                     \
    ARRAY(bias, k)                                                                                     \
    ARRAY(tau, n)                                                                                      \
    ARRAY(law, 1)                                                                                      \
    ARRAY(kp, r)                                                                                       \
    ARRAY(kd, r)                                                                                       \
    ARRAY(f_min, m)                                                                                    \
    ARRAY(f_max, m)                                                                                    \
    ARRAY(H_f, m)                                                                                      \
    ARRAY(norm, 1)                                                                                     \
    ARRAY(passive, n)                                                                                  \
    ARRAY(tolerance, 1)                                                                                \
    ARRAY(H_q, n)                                                                                      \
    ARRAY(H_r, m)                                                                                      \
    ARRAY(f_p, m)                                                                                      \
    ARRAY(W, k)                                                                                        \
    ARRAY(priority, k)                                                                                 \
    ARRAY(posture_kp, n)                                                                               \
    ARRAY(posture_kd, n)                                                                               \
    ARRAY(q0, n)                                                                                       \
    ARRAY(q_min, n)                                                                                    \
    ARRAY(q_max, n)                                                                                    \
    ARRAY(limit_bandwidth, 1)                                                                          \
    ARRAY(forces, m)                                                                                   \
    ARRAY(slack, r)                                                                                    \
    ARRAY(qdd, n)                                                                                      \
    ARRAY(limits_dropped, 1)                                                                           \
    ARRAY(memory, m + 2 * rows) /* last forces, and starts of both programs */                         \
    ARRAY(desired, r)           /* acceleration of joints or tasks */                                  \
    ARRAY(active_tau, n)        /* tau, after elimination of passive coordinates */                    \
    ARRAY(target, k)            /* J qdd of each task: desired, or result of a priority */             \
    ARRAY(squares, m)           /* least-squares forces, before another norm */                        \
    ARRAY(apart, m)             /* distance from f_p, and direction of a step */                       \
    ARRAY(way, m)                                                                                      \
    ARRAY(factor, n *n)

struct computed_torque {
    size_t n, m, k, r, rows;
    dual_newton *hard;  /* the program with hard rows */
    void *second;       /* memory of another program, see program.h, for that number of variables */
    size_t second_variables;
    dual_newton *built; /* the last program that was built */
    real rank;          /* priority of the program */
    int limited;        /* whether joint limits bound its qdd */
    int worst;          /* status of the priorities up to now */
    TORQUE_ARRAYS(NAMED_MEMBER)
};

#endif
