/* The inside of an estimator. */
#ifndef CARDSFLOW_ESTIMATOR_STATE_H
#define CARDSFLOW_ESTIMATOR_STATE_H

#include "../blob/state.h"
#include "estimator.h"

/* ARRAY(name, number of reals): those of estimator_array, then room. What is remembered follows on one another. */
#define ESTIMATOR_REMEMBERED(ARRAY)                                                                    \
    ARRAY(state, N)                                                                                    \
    ARRAY(covariance, N *N)                                                                            \
    ARRAY(last_tensions, m) /* the last ones that were numbers */                                      \
    ARRAY(slips, bends)     /* of cables with friction, see cable_friction.c */                        \
    ARRAY(sd, N)                                                                                       \
    ARRAY(innovation, 1)                                                                               \
    ARRAY(mean_innovation, 1) /* over innovation_time */                                               \
    ARRAY(blind, 1)           /* since the last measurement, in [s] */                                 \
    ARRAY(used, 1)                                                                                     \
    ARRAY(status, 1)                                                                                   \
    ARRAY(valid, 1)
#define ESTIMATOR_ARRAYS(ARRAY)                                                                        \
    ARRAY(lengths, m)                                                                                  \
    ARRAY(tensions, m)                                                                                 \
    ARRAY(torques, n)                                                                                  \
    ARRAY(encoders, n)                                                                                 \
    ARRAY(gyroscope, 3 * i)                                                                            \
    ARRAY(accelerometer, 3 * i)                                                                        \
    ARRAY(length_noise, m)                                                                             \
    ARRAY(encoder_noise, n)                                                                            \
    ARRAY(gyroscope_noise, i)                                                                          \
    ARRAY(accelerometer_noise, i)                                                                      \
    ARRAY(offset, m)                                                                                   \
    ARRAY(compliance, m)                                                                               \
    ARRAY(slack, 1)                                                                                    \
    ARRAY(gate, 1)                                                                                     \
    ARRAY(acceleration_noise, n)                                                                       \
    ARRAY(load_drift, n)                                                                               \
    ARRAY(bias_drift, 2)                                                                               \
    ARRAY(imu_rotation, 9 * i)                                                                         \
    ARRAY(imu_position, 3 * i)                                                                         \
    ARRAY(search, 1)                                                                                   \
    ARRAY(starts, 1)                                                                                   \
    ARRAY(start, n)                                                                                    \
    ARRAY(start_low, n)                                                                                \
    ARRAY(start_high, n)                                                                               \
    ARRAY(start_sd, 3 * n + 2)                                                                         \
    ARRAY(largest_sd, n)                                                                               \
    ARRAY(largest_innovation, 1)                                                                       \
    ARRAY(innovation_time, 1)                                                                          \
    ARRAY(first_poses, 2 * n + 2)                                                                      \
    ESTIMATOR_REMEMBERED(ARRAY)                                                                        \
    ARRAY(transition, 6 * n * n)  /* q and qd after a step by q, qd, w before it, 2 n x 3 n */         \
    ARRAY(differential, 4 * n * n) /* the part by q and qd */                                          \
    ARRAY(product, 2 * n * N)                                                                          \
    ARRAY(matrix, n *n)                                                                                \
    ARRAY(factor, n *n)                                                                                \
    ARRAY(column, n)                                                                                   \
    ARRAY(load, n)                                                                                     \
    ARRAY(gain, N)                                                                                     \
    ARRAY(shift, N)               /* what the measurements of a tick have changed so far */            \
    ARRAY(row, 4 * n)             /* of a measurement by q, qd and w; and what it is made of */        \
    ARRAY(wide_row, 2 * variables)                                                                     \
    ARRAY(rates, variables)       /* accelerations of all variables */                                 \
    ARRAY(pose, 3 * n)            /* of the search: here, next, way */

#define ESTIMATOR_MEMBER(name, length) real *name;
struct estimator {
    core *core;
    size_t n, m, i, N, variables, bends;
    const int32_t *imu_frame;
    estimator_transition *exact;
    void *exact_self;
    real step;    /* of the last prediction, in [s] */
    size_t seen, taken; /* measurements of this tick; those within the gate */
    real squares; /* of their innovations, over the variance */
    ESTIMATOR_ARRAYS(ESTIMATOR_MEMBER)
};
#undef ESTIMATOR_MEMBER

/* Whether a standard deviation says that something is measured. */
static inline int is_measured(real noise)
{
    return noise > 0 && noise <= CORE_LARGEST_STATE;
}

static inline int is_number(real x)
{
    return x <= CORE_LARGEST_STATE && x >= -CORE_LARGEST_STATE;
}

/* Whether the length of a muscle is measured, and tells where the robot is. */
static inline int is_taut(const estimator *e, size_t k)
{
    return is_measured(e->length_noise[k]) && is_number(e->lengths[k]) &&
           e->last_tensions[k] > e->slack[0];
}

/* l(q) of a measured length. */
static inline real path_length(const estimator *e, size_t k)
{
    return e->lengths[k] - e->offset[k] + e->compliance[k] * e->last_tensions[k];
}

#endif
