/* Estimator of the state of a robot from its muscles: an extended Kalman filter that uses the step of the
   core.

   The state x consists of q, qd; w, an unknown generalised load on the left side of the motion equation,

     M qdd + C + G + w = -L'f,

   for each IMU the biases of gyroscope and accelerometer; and optionally the changes of all length offsets b since
   the reset. Loads, biases and offsets are random walks.

     x <- step(x, f),   P <- A P A' + Q          with the measured tensions f

     l_m = l(q) - c f + b + noise                length of a cable at its motor: c its compliance, b its offset
     z = q_j + noise                             joint with an encoder
     gyroscope, accelerometer of a link          angular velocity, specific force, in the axes of the IMU

   Measurements are processed one by one as scalars, so that no matrix is inverted (Bierman 1977, ch. II). A
   measurement is skipped if it is not finite, if its innovation exceeds `gate` standard deviations, or if
   its muscle is slack.

   The estimator does not allocate memory, has no global state and no I/O. It needs its own core handle, of a
   robot whose driven muscles are ideal cables, so that the commands are the tensions, and without joint
   limits. Every function of one handle must be called from one thread at a time. */
#ifndef CARDSFLOW_ESTIMATOR_H
#define CARDSFLOW_ESTIMATOR_H

#include "../core.h"

typedef struct estimator estimator;

enum estimator_status {
    ESTIMATOR_WAITING = 0,      /* waiting for the first measurements */
    ESTIMATOR_TRACKING = 1,
    ESTIMATOR_AMBIGUOUS = 2,    /* two poses fit the first measurements */
    ESTIMATOR_NO_FIT = 3,       /* no pose matches them */
    ESTIMATOR_UNOBSERVABLE = 4, /* too few taut muscles to determine the first pose */
    ESTIMATOR_DIVERGED = 5,     /* until the next reset */
    ESTIMATOR_NOT_CONVERGED = 6 /* tracking, but a horizon did not converge in the last tick: not valid */
};

/* Return the size of the working memory in bytes. imus: number of IMUs; offsets: 0 if length offsets are constant, or
   the number of muscles. */
CORE_API size_t estimator_size(const core *c, int32_t imus, int32_t offsets);

/* Create a handle in `memory`, which is 8-byte aligned and has estimator_size bytes; this call sets it to
   zero. Neither core nor memory may be moved. imu_frame is the frame of each IMU in the blob. Return NULL if
   a frame does not exist. */
CORE_API estimator *estimator_open(core *c, int32_t imus, const int32_t *imu_frame, int32_t offsets, void *memory);

/* Return an array by name, and its number of elements; NULL if the array does not exist. n coordinates, m
   muscles, i IMUs, o offsets.

   Measurements, to be written before a tick; NaN if a measurement is missing
     lengths             l_m, m, in [m]
     tensions            mean during the tick, m, in [N]
     torques             torques of motors at joints, n; 0 without a motor
     encoders            n
     gyroscope, accelerometer   3 i, in [rad/s] and [m/s2]

   Settings, to be written before a reset. Standard deviations of one measurement; 0 or infinite: not measured
     length_noise        m, in [m]
     encoder_noise       n
     gyroscope_noise, accelerometer_noise       i
     offset, compliance  b, m, in [m]; c, m, in [m/N]
     slack               1: minimum tension of a muscle that is used, in [N]
     gate                1: in standard deviations; after a tick in which most measurements exceeded it, the filter
                         ignores it, and velocities and loads are as uncertain as at the start
     acceleration_noise  n: density of white noise, in [rad/s2] times the root of a second
     load_drift          n: density of the noise of dw/dt
     tension_noise, tension_error    m, in [N]; m, relative: standard deviations of measured tensions, white; with them,
                         a change beyond the gate may have occurred at any time of the tick
     bias_drift          2: of gyroscopes and of accelerometers
     offset_drift        o: density of the noise of db/dt
     imu_rotation        axes of an IMU in its frame, row by row, 9 i
     imu_position        in its frame, 3 i, in [m]
     search              1: whether to search the first pose
     starts              1: number of poses from which the search starts
     start               q, n; pose at a reset, or the first start of the search
     start_low, start_high   n: range of the search
     start_sd            standard deviations of q, qd, w, of gyroscope and accelerometer biases; 3 n + 2
     start_offset_sd     o, of the offsets
     largest_sd          n: maximum standard deviation of q of a valid estimate
     largest_innovation  1: maximum mean of (innovation / its standard deviation)^2 of a valid estimate
     innovation_time     1: averaging time of that mean, in [s]; an estimate without measurements for this time is
                         not valid

     huber               1, only with a horizon: residual from which the loss is linear, in standard
                         deviations; 0: always quadratic
     low, high           n, only with a horizon: bounds of q; infinite without a bound

   Results
     state               q, qd, w, biases, changes of the offsets: 3 n + 6 i + o
     sd                  standard deviations of the state
     innovation          1: mean of these squares in the last tick, about 1 if the model is correct
     used                1: number of measurements used in the last tick
     status              1: an enum estimator_status
     valid               1: 1 or 0
     iterations          1, only with a horizon: of its solver in the last tick
     x                   K (3 n + 6 i + o), only with a horizon: states of the frames

   Internal state, to be saved and restored
     remembered
     remembered_frames   only with a horizon

   Working memory
     first_poses         of the search: the best pose, the second best; their sums of squares; 2 n + 2 */
CORE_API real *estimator_array(estimator *e, const char *name, size_t *length);

/* Return whether an estimator with this status advances its state in a tick. */
static inline int estimator_is_tracking(int status)
{
    return status == ESTIMATOR_TRACKING || status == ESTIMATOR_NOT_CONVERGED;
}

/* Reset to the start state, which is valid if its standard deviations are small enough. */
CORE_API void estimator_reset(estimator *e);

/* Advance by steps of h with the measured tensions, then process the measurements. Return an enum
   estimator_status. */
CORE_API int estimator_tick(estimator *e, real h, int32_t steps);

/* Search the pose that fits the measurements best, from several starts, by the Levenberg-Marquardt method.
   It becomes the state if it is observable. Return an enum estimator_status. */
CORE_API int estimator_find(estimator *e);

/* Compute the derivatives of q+ and qd+ by q and qd in a core_step, 2 n x 2 n, row by row. Return 0, or
   nonzero if the step is impossible. `extra` as in core_step. */
typedef int estimator_transition(void *self, const real *q, const real *qd, const real *f, const real *extra, real h,
                                 real *A);

/* Use this function for the transition matrix, see tangent/transition.h. The default, also for NULL, is [I
   hI; 0 I]. */
CORE_API void estimator_use_transition(estimator *e, estimator_transition *transition, void *self);

/* Return the size of the memory of a horizon in bytes; 0 if the number of frames is not from 2 to 1000. */
CORE_API size_t estimator_horizon_size(const core *c, int32_t imus, int32_t offsets, int32_t frames);

/* Estimate by the last measurements, of `frames` ticks, with bounds and robust losses, see horizon/frames.h. `memory` is
   8-byte aligned; this call sets it to zero. Call it before settings are written. Return nonzero if the memory
   is rejected. */
CORE_API int estimator_use_horizon(estimator *e, int32_t frames, void *memory);

#endif
