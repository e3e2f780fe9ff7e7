/* Detection and isolation of single faults of cables, motors and sensors.

   Lengths and encoders are compared with each other by geometry only, so that unknown loads, contacts and wrong
   masses have no effect. In each tick, all coordinates are fitted to all sensors (least squares); the residual of
   a sensor is its deviation from the fit of the other sensors, divided by its standard deviation. Tensions are
   compared with the commands after the lag of the motors. Without tension sensors, faults of motors are not found, and
   a broken cable is reported as a stuck length sensor.

   A sensor becomes suspect if its statistic exceeds a threshold that a robot without faults exceeds less often than
   `false_alarms_per_hour`; see statistics.c. Then each hypothesis (kind, part, time) has a Bayes factor against no
   fault; the most probable one is reported; see isolate.c.

   The monitor does not allocate memory, has no global state and no I/O. Write the inputs, then call
   faults_tick. */
#ifndef CARDSFLOW_FAULTS_H
#define CARDSFLOW_FAULTS_H

#include "../qp/dual_newton.h"

typedef struct faults faults;

enum fault_kind {
    FAULT_NONE = 0,
    FAULT_BROKEN = 1,         /* muscle: no force */
    FAULT_JAMMED = 2,         /* muscle: force of a spring */
    FAULT_WEAK = 3,           /* muscle: force multiplied by `value` */
    FAULT_LENGTH_STUCK = 4,   /* length sensor */
    FAULT_LENGTH_BIAS = 5,    /* length sensor: offset `value`; also a cable off its pulley */
    FAULT_LENGTH_SCALE = 6,   /* length sensor: changes multiplied by `value` */
    FAULT_LENGTH_SWAPPED = 7, /* length sensor: exchanged with the muscle `other` */
    FAULT_TENSION_STUCK = 8,  /* tension sensor */
    FAULT_TENSION_DEAD = 9,   /* tension sensor: 0 */
    FAULT_ENCODER_STUCK = 10, /* encoder */
};

/* Return the size of the working memory in bytes for n coordinates and m muscles; 0 if a number is invalid. */
DUAL_NEWTON_API size_t faults_size(int coordinates, int muscles);

/* Create a monitor in `memory`, which is 8-byte aligned and has faults_size bytes. */
DUAL_NEWTON_API faults *faults_open(int coordinates, int muscles, void *memory);

/* Return an array by name, and its number of elements; NULL if it does not exist. A part is, in this order, one of
   m muscles, m length sensors, m tension sensors, n encoders: p = 3 m + n.

   Inputs of a tick; NaN if a measurement is missing
     lengths            m, measured minus offset plus compliance times tension, in [m]
     encoders           n
     tensions           m, in [N]
     commands           m, forces commanded during the last tick, in [N]
     q                  n, estimate
     path_lengths       m, l(q)
     jacobian           m n, L(q), row by row
   Inputs of faults_move
     acceleration       n, mean of the tick by the model with the forces `acting` and without loads
     mobility           n n, inverse mass matrix
     acting             m, forces of the model, in [N]
     velocity, load     n, estimate; only used at the start

   Settings, to be written before a reset
     false_alarms_per_hour  1
     length_noise       m, standard deviation of white noise, in [m]; 0 or infinite: not measured
     length_error       m, standard deviation of constant errors of the model, in [m]
     encoder_noise      n
     tension_noise      m, in [N]
     tension_error      m, relative
     motor_lag          1, time constant, in [s]
     force_rate         m, maximum rate of the forces that are sent, in [N/s]; infinite without a limit
     command_delay      1, ticks from a command to the measurement of its tension, at most 60; lengths and encoders
                        are compared with each other only, so that their delay has no effect
     start              1, time from which tensions follow the commands, in [s]
     f_max              m, in [N]
     load_noise         n, density of the noise of dw/dt of unknown loads
     load_change        n, standard deviation of sudden changes of them; 0: the motion is not tested

   Results
     kind               p, enum fault_kind; it remains until a reset
     time               p, time of the decision since the reset, in [s]
     begin              p, estimated time of the fault, in [s]
     statistic          p, log Bayes factor of the fault against no fault at the decision
     threshold          p, of half the squared normalised mean of a window, from which a sensor is suspect
     confidence         p, probability of the kind and the part among all hypotheses
     value              p, factor or offset of the fault
     other              p, index of the other muscle, or -1
     usable             p, 1 or 0: whether a muscle can be commanded, a sensor can be used
     bound              m, maximum force that the muscle can produce: f_max, 0 if broken; last force if jammed
     suspect            p, 1 while a fault is tested; the sensor should not be used

   Internal state, to be saved and restored
     remembered */
DUAL_NEWTON_API real *faults_array(faults *s, const char *name, size_t *length);

DUAL_NEWTON_API void faults_reset(faults *s);

enum faults_pose_status { FAULTS_POSE_NEAR = 0, FAULTS_POSE_FAR = 1, FAULTS_POSE_UNKNOWN = 2 };

/* Compare q with the fit of the coordinates to lengths and encoders, since an estimate may be wrong after a fault. Return
   an enum faults_pose_status: UNKNOWN if the sensors do not determine q; FAR if geometry is not linear up to the fit, to
   which q is then moved; the caller computes path_lengths and jacobian there, and repeats the fit. */
DUAL_NEWTON_API int faults_pose(faults *s);

/* Process the inputs of a tick of h seconds, after faults_pose has returned NEAR for them. Return the number of parts with faults. */
DUAL_NEWTON_API int faults_tick(faults *s, real h);

/* Test the motion that ends at the measurements of the last faults_tick: h seconds, in equal steps. Only without tension
   sensors. Return the number of parts with faults. */
DUAL_NEWTON_API int faults_move(faults *s, real h, int steps);

#endif
