/* Internal state of an estimator. */
#ifndef CARDSFLOW_ESTIMATOR_STATE_H
#define CARDSFLOW_ESTIMATOR_STATE_H

#include "../blob/state.h"
#include "estimator.h"

/* ARRAY(name, number of reals): arrays of estimator_array, then working memory. The arrays that form the
   internal state are contiguous. */
#define ESTIMATOR_REMEMBERED(ARRAY)                                                                    \
    ARRAY(state, N)                                                                                    \
    ARRAY(covariance, N *N)                                                                            \
    ARRAY(last_tensions, m) /* last finite tensions */                                                 \
    ARRAY(slips, bends)     /* of cables with friction, see cable_friction.c */                        \
    ARRAY(sd, N)                                                                                       \
    ARRAY(innovation, 1)                                                                               \
    ARRAY(mean_innovation, 1) /* mean over innovation_time */                                          \
    ARRAY(blind, 1)           /* time since the last measurement, in [s] */                            \
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
    ARRAY(tension_noise, m)                                                                            \
    ARRAY(tension_error, m)                                                                            \
    ARRAY(bias_drift, 2)                                                                               \
    ARRAY(offset_drift, o)                                                                             \
    ARRAY(imu_rotation, 9 * i)                                                                         \
    ARRAY(imu_position, 3 * i)                                                                         \
    ARRAY(search, 1)                                                                                   \
    ARRAY(starts, 1)                                                                                   \
    ARRAY(start, n)                                                                                    \
    ARRAY(start_low, n)                                                                                \
    ARRAY(start_high, n)                                                                               \
    ARRAY(start_sd, 3 * n + 2)                                                                         \
    ARRAY(start_offset_sd, o)                                                                          \
    ARRAY(largest_sd, n)                                                                               \
    ARRAY(largest_innovation, 1)                                                                       \
    ARRAY(innovation_time, 1)                                                                          \
    ARRAY(first_poses, 2 * n + 2)                                                                      \
    ESTIMATOR_REMEMBERED(ARRAY)                                                                        \
    ARRAY(transition, 6 * n * n)  /* derivatives of q+ and qd+ by q, qd, w, 2 n x 3 n */               \
    ARRAY(differential, 4 * n * n) /* derivatives by q and qd */                                       \
    ARRAY(product, 2 * n * N)                                                                          \
    ARRAY(matrix, n *n)                                                                                \
    ARRAY(changes, m)             /* of tensions since the last tick */                                \
    ARRAY(jitter, n *n)           /* covariance of accelerations due to the noise of tensions */       \
    ARRAY(factor, n *n)                                                                                \
    ARRAY(column, n)                                                                                   \
    ARRAY(load, n)                                                                                     \
    ARRAY(gain, N)                                                                                     \
    ARRAY(shift, N)               /* sum of corrections in a tick */                                   \
    ARRAY(row, 4 * n)             /* derivatives of a measurement by q, qd, w; work */                 \
    ARRAY(wide_row, 2 * variables)                                                                     \
    ARRAY(rates, variables)       /* accelerations of all variables */                                 \
    ARRAY(pose, 3 * n)            /* of the search: current pose, next, step */

enum { MAX_IMUS = 64 };

struct estimator {
    core *core;
    size_t n, m, i, o, N, variables, bends; /* o: m, or 0 if offsets are constant */
    const int32_t *imu_frame;
    estimator_transition *exact;
    void *exact_self;
    struct horizon *horizon; /* NULL for the Kalman filter */
    int is_collecting;       /* whether measurements become terms of the horizon, see horizon/terms.h */
    real step;    /* of the last prediction, in [s] */
    real interval; /* between the last measurements, in [s] */
    size_t seen, taken; /* number of measurements in this tick; of those within the gate */
    real squares; /* sum of their squared innovations over the variance */
    ESTIMATOR_ARRAYS(NAMED_MEMBER)
};

/* Return whether an estimator can have these numbers of IMUs and offsets. */
static inline int estimator_can_have(const core *c, int32_t imus, int32_t offsets)
{
    return imus >= 0 && imus <= MAX_IMUS && (offsets == 0 || offsets == c->blob.counts.muscles);
}

/* Return whether a noise setting enables a measurement. */
static inline int is_measured(real noise)
{
    return noise > 0 && noise <= CORE_MAX_STATE;
}

static inline int is_number(real x)
{
    return x <= CORE_MAX_STATE && x >= -CORE_MAX_STATE;
}

/* Return whether the length of a muscle is measured. */
static inline int has_length(const estimator *e, size_t k)
{
    return is_measured(e->length_noise[k]) && is_number(e->lengths[k]);
}

/* Return whether the length of a muscle is measured and the muscle is taut. */
static inline int is_taut(const estimator *e, size_t k)
{
    return has_length(e, k) && e->last_tensions[k] > e->slack[0];
}

/* Return whether most measurements of the last tick exceeded the gate of the filter. Then the state is probably wrong, as
   after an impact, and the sensors are correct. */
static inline int most_exceed_gate(const estimator *e)
{
    return !e->horizon && e->innovation[0] > e->gate[0] * e->gate[0] / 2;
}

/* Return the state with the change of the offset of muscle k; N if offsets are constant. */
static inline size_t offset_state(const estimator *e, size_t k)
{
    return e->o ? e->N - e->o + k : e->N;
}

/* Return l(q) for a measured length. */
static inline real path_length(const estimator *e, size_t k)
{
    const real length = e->lengths[k] - e->offset[k] + e->compliance[k] * e->last_tensions[k];
    return e->o ? length - e->state[offset_state(e, k)] : length;
}

#endif
