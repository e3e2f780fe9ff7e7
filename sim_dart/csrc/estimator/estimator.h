/* The state of a robot from its muscles: an extended Kalman filter on the core's own step.

   The state x is q, qd; w, a generalised load that the model does not know, on the left of the motion equation,
     M qdd + C + G + w = -L'f,
   and of each inertial unit the biases of gyroscope and accelerometer. Loads and biases are random walks.

     x <- step(x, f),   P <- A P A' + Q          with the tensions f as measured
     l_m = l(q) - c f + b + noise                length of a cable at its motor: c its compliance, b its offset
     z = q_j + noise                             of joints with an encoder
     gyroscope, accelerometer of a link          angular velocity, specific force, in its own axes

   Measurements are taken one by one, each as a scalar, so that nothing is inverted (Bierman 1977, ch. II); one that
   is farther from what is expected than `gate` standard deviations is left out, and so are those of slack
   muscles, and what is not a number.

   No allocation, no global state, no I/O. The core handle is the estimator's own: a robot whose driven muscles are
   ideal cables, so that a tension is what a cable is commanded, and without joint limits. Every function of one
   handle must be called from one thread at a time.                                                       */
#ifndef CARDSFLOW_ESTIMATOR_H
#define CARDSFLOW_ESTIMATOR_H

#include "../core.h"

typedef struct estimator estimator;

enum estimator_status {
    ESTIMATOR_WAITING = 0,      /* for the first measurements */
    ESTIMATOR_TRACKING = 1,
    ESTIMATOR_AMBIGUOUS = 2,    /* two poses fit the first measurements: none is taken */
    ESTIMATOR_NO_FIT = 3,       /* no pose matches them */
    ESTIMATOR_UNOBSERVABLE = 4, /* too few muscles are taut to tell the first pose */
    ESTIMATOR_DIVERGED = 5      /* until the next reset */
};

/* Bytes of working memory. imus: inertial units on links. */
CORE_API size_t estimator_size(const core *c, int32_t imus);

/* A handle in `memory`, 8-byte aligned and of estimator_size bytes, zeroed by this call; both must not be moved.
   imu_frame says which frame of the blob each unit is on. NULL if a frame does not exist.               */
CORE_API estimator *estimator_open(core *c, int32_t imus, const int32_t *imu_frame, void *memory);

/* An array by name, and its number of elements; NULL if there is no such array. n coordinates, m muscles, i units.
   Measurements, to be written before a tick; NaN if one is missing
     lengths             l_m, m, in [m]
     tensions            mean of the tick, m, in [N]
     torques             of motors at joints, n; 0 if there is none
     encoders            n
     gyroscope, accelerometer   3 i, in [rad/s] and [m/s2]
   Settings, to be written before a reset. Standard deviations of one reading; 0 or infinite: not measured
     length_noise        m, in [m]
     encoder_noise       n
     gyroscope_noise, accelerometer_noise       i
     offset, compliance  b, m, in [m]; c, m, in [m/N]
     slack               1: a muscle with less tension is left out, in [N]
     gate                1: in standard deviations
     acceleration_noise  n: density of white noise, in [rad/s2] times the root of a second
     load_drift          n: the same of dw/dt
     bias_drift          2: of gyroscopes and of accelerometers
     imu_rotation        row by row, of a unit's axes in its frame, 9 i
     imu_position        in its frame, 3 i, in [m]
     search              1: whether to search the first pose
     starts              1: how many poses the search begins from
     start               q, n; pose at a reset, or the first one that the search begins from
     start_low, start_high   n: where the search looks
     start_sd            standard deviations of q, qd, w, of gyroscopes' and accelerometers' biases; 3 n + 2
     largest_sd          n: of q, beyond which an estimate is not valid
     largest_innovation  1: mean of (innovation / its standard deviation)^2, likewise
     innovation_time     1: over which it is averaged, in [s]; without any measurement for so long nothing is valid
   Results
     state               q, qd, w, biases: 3 n + 6 i
     sd                  standard deviations of these
     innovation          1: the mean of the last tick's squares, about 1 where the model is right
     used                1: how many measurements the last tick took
     status              1: an enum estimator_status
     valid               1: 1 or 0
   Everything that it remembers
     remembered
   Room
     first_poses         of the search: the best pose, the second best; their sums of squares; 2 n + 2      */
CORE_API real *estimator_array(estimator *e, const char *name, size_t *length);

/* Forget all: the state is that of the start, which is valid if it is known well enough. */
CORE_API void estimator_reset(estimator *e);

/* Advance by steps of h with the tensions as they are, then take the measurements. An enum estimator_status. */
CORE_API int estimator_tick(estimator *e, real h, int32_t steps);

/* The pose that fits the measurements best, from several starts, by Levenberg and Marquardt's rule; the state
   becomes that, if it is observable. An enum estimator_status.                                                  */
CORE_API int estimator_find(estimator *e);

/* How q+ and qd+ change with q and qd in a core_step, 2 n x 2 n, row by row; 0, or nonzero if there is no
   such step. `extra` as of core_step.                                                                      */
typedef int estimator_transition(void *self, const real *q, const real *qd, const real *f, const real *extra, real h,
                                 real *A);

/* Take the transition matrix from a function, tangent/transition.h; else, and for NULL, it is [I hI; 0 I]. */
CORE_API void estimator_use_transition(estimator *e, estimator_transition *transition, void *self);

#endif
