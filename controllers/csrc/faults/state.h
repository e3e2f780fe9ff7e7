/* Internal state of a monitor.

   A channel is a sensor: m lengths, m tensions, n encoders. For each channel and each of the last WINDOW ticks
   the monitor stores the prediction from other sensors or commands, the residual (measured minus predicted), and
   its weight, the inverse of its variance. */
#ifndef CARDSFLOW_FAULTS_STATE_H
#define CARDSFLOW_FAULTS_STATE_H

#include "../../../sim_dart/csrc/math/elementary.h"
#include "../../../sim_dart/csrc/named_arrays.h"
#include "faults.h"

enum { WINDOW = 64, MOTION_WINDOW = 32, ONSETS = 3, PART = 4, SIGNS = 4, RISES = 6, TURN = 1 << 20 };

/* ARRAY(name, number of reals). c channels, p parts. The arrays from clock to count form the internal state. */
#define FAULTS_NAMED(ARRAY)                                                                            \
    ARRAY(lengths, m)                                                                                  \
    ARRAY(encoders, n)                                                                                 \
    ARRAY(tensions, m)                                                                                 \
    ARRAY(commands, m)                                                                                 \
    ARRAY(q, n)                                                                                        \
    ARRAY(path_lengths, m)                                                                             \
    ARRAY(jacobian, m *n)                                                                              \
    ARRAY(false_alarms_per_hour, 1)                                                                    \
    ARRAY(length_noise, m)                                                                             \
    ARRAY(length_error, m)                                                                             \
    ARRAY(encoder_noise, n)                                                                            \
    ARRAY(tension_noise, m)                                                                            \
    ARRAY(tension_error, m)                                                                            \
    ARRAY(motor_lag, 1)                                                                                \
    ARRAY(force_rate, m)                                                                               \
    ARRAY(command_delay, 1)                                                                            \
    ARRAY(start, 1)                                                                                    \
    ARRAY(f_max, m)                                                                                    \
    ARRAY(acceleration, n)                                                                             \
    ARRAY(mobility, n *n)                                                                              \
    ARRAY(acting, m)                                                                                   \
    ARRAY(velocity, n)                                                                                 \
    ARRAY(load, n)                                                                                     \
    ARRAY(load_noise, n)                                                                               \
    ARRAY(load_change, n)                                                                              \
    ARRAY(clock, 1)        /* ticks since the reset, minus multiples of TURN */                        \
    ARRAY(kind, p)                                                                                     \
    ARRAY(time, p)                                                                                     \
    ARRAY(begin, p)                                                                                    \
    ARRAY(statistic, p)                                                                                \
    ARRAY(threshold, p)                                                                                \
    ARRAY(confidence, p)                                                                               \
    ARRAY(value, p)                                                                                    \
    ARRAY(other, p)                                                                                    \
    ARRAY(usable, p)                                                                                   \
    ARRAY(suspect, p)                                                                                  \
    ARRAY(bound, m)
#define FAULTS_REMEMBERED(ARRAY)                                                                       \
    ARRAY(now, 1)          /* in [s]; its rounding error */                                            \
    ARRAY(now_rest, 1)                                                                                 \
    ARRAY(sent, WINDOW *m) /* commands with limited rates */                                           \
    ARRAY(expected, m)     /* tension after the lag of the motor  */                                   \
    ARRAY(residual, WINDOW *c)                                                                         \
    ARRAY(weight, WINDOW *c)                                                                           \
    ARRAY(sums, WINDOW *c) /* of weight times residual, and of weights, in PART ticks */               \
    ARRAY(weights, WINDOW *c)                                                                          \
    ARRAY(predicted, WINDOW *c)                                                                        \
    ARRAY(since, c)        /* first tick that may be used */                                           \
    ARRAY(last, c)         /* last measured value */                                                   \
    ARRAY(last_change, c)                                                                              \
    ARRAY(seen, c)         /* number of measurements, of repeated values */                            \
    ARRAY(repeats, c)                                                                                  \
    ARRAY(roughness, c)    /* sum of squared second differences of a block, and their number */        \
    ARRAY(rough, c)                                                                                    \
    ARRAY(smoothest, c)    /* smallest mean of a block */                                              \
    ARRAY(resolution, c)   /* smallest change */                                                       \
    ARRAY(run, c)          /* repeated values up to now, and their log likelihood ratio */             \
    ARRAY(evidence, c)                                                                                 \
    ARRAY(suspicion, c)    /* tick at which a channel became suspect; -1: it is not */                 \
    ARRAY(motion_begin, 1) /* tick of the start of the filter; -1: none. Its last tick */              \
    ARRAY(loaded, 1)       /* 1 after the first change of the load */                                  \
    ARRAY(motion_tick, 1)                                                                              \
    ARRAY(motion_state, 6 * n) /* of two filters */                                                    \
    ARRAY(motion_covariance, 18 * n *n)                                                                \
    ARRAY(motion_force, m)    /* after the lag of the motors, at the end of the tick */               \
    ARRAY(motion_gain, MOTION_WINDOW * 3 * n *n)                                                       \
    ARRAY(motion_mobility, MOTION_WINDOW * n *n)                                                       \
    ARRAY(motion_factor, MOTION_WINDOW * n *n)                                                         \
    ARRAY(motion_white, MOTION_WINDOW * n)                                                             \
    ARRAY(motion_forces, MOTION_WINDOW * m)                                                            \
    ARRAY(motion_lengths, MOTION_WINDOW * m)                                                           \
    ARRAY(motion_jacobian, MOTION_WINDOW * m *n)                                                       \
    ARRAY(motion_agile, MOTION_WINDOW)                                                                 \
    ARRAY(agility, 1)         /* factor of the variance of the drift */                                \
    ARRAY(followed, 1)        /* ticks since a change was detected; -1: none */                        \
    ARRAY(began, ONSETS)      /* ticks at which it may have begun; for each of these: */               \
    ARRAY(force_began, ONSETS *m)                                                                      \
    ARRAY(length_began, ONSETS *m)                                                                     \
    ARRAY(signatures, ONSETS * (RISES * n + SIGNS * m) * 3 * n) /* of unit loads and of muscles */     \
    ARRAY(load_score, ONSETS * RISES * n)                                                              \
    ARRAY(load_info, ONSETS * RISES * n * n)                                                           \
    ARRAY(score, ONSETS * m * SIGNS)                                                                   \
    ARRAY(info, ONSETS * m * SIGNS * SIGNS)                                                            \
    ARRAY(squares, ONSETS)    /* sums of squared white innovations, of motion_agile; their number */   \
    ARRAY(agile, ONSETS)                                                                               \
    ARRAY(count, ONSETS)
#define FAULTS_WORK(ARRAY)                                                                             \
    ARRAY(normal, n *n)   /* of the least squares; its factor */                                       \
    ARRAY(factor, n *n)                                                                                \
    ARRAY(shift, n)                                                                                    \
    ARRAY(row, n)                                                                                      \
    ARRAY(solved, n)                                                                                   \
    ARRAY(spread, n *n)   /* covariance of the fit */                                                  \
    ARRAY(matrix, (n + SIGNS) * n)                                                                     \
    ARRAY(signal_factor, n *n)                                                                         \
    ARRAY(signal, n)                                                                                   \
    ARRAY(agile_gain, 3 * n *n)                                                                        \
    ARRAY(agile_factor, n *n)                                                                          \
    ARRAY(agile_white, n)                                                                              \
    ARRAY(substeps, 1)    /* q+ = q + h qd + substeps h^2 qdd, for equal steps within a tick */        \
    ARRAY(error, c)       /* standard deviation of the constant error of a prediction */               \
    ARRAY(sum, c)         /* of weighted residuals in a window, and of weights */                      \
    ARRAY(information, c)                                                                              \
    ARRAY(level, c)       /* largest statistic of each channel in this tick; 0 below its threshold */  \
    ARRAY(onset, c)       /* tick at which its window begins */
#define FAULTS_ARRAYS(ARRAY) FAULTS_NAMED(ARRAY) FAULTS_REMEMBERED(ARRAY) FAULTS_WORK(ARRAY)

struct faults {
    size_t n, m, c, p;
    real limit, repeat_limit; /* thresholds in this tick */
    real step;                /* of this tick, in [s] */
    FAULTS_ARRAYS(NAMED_MEMBER)
};

static inline int faults_is_number(real x)
{
    return x - x == 0;
}

/* Return whether a noise setting enables a measurement. */
static inline int faults_is_measured(real noise)
{
    return noise > 0 && faults_is_number(noise);
}

/* Return the index of a channel at a tick in the stored arrays. */
static inline size_t faults_at(const faults *s, size_t channel, real tick)
{
    return (size_t)tick % WINDOW * s->c + channel;
}

/* Return the part of a channel: sensors follow the muscles. */
static inline size_t faults_part(const faults *s, size_t channel)
{
    return s->m + channel;
}

/* Return whether a channel is used: its sensor has neither a fault nor a suspicion. */
static inline int faults_is_used(const faults *s, size_t channel)
{
    return s->usable[faults_part(s, channel)] != 0 && s->suspicion[channel] < 0;
}

/* Store residuals of lengths and encoders against the fit of the others, by faults_pose; of tensions against the commands. */
void faults_fit(faults *s);
void faults_compare_tensions(faults *s, real h);

/* Update the counts of repeated values of a channel, whose noise has a variance according to the settings. */
void faults_count(faults *s, size_t channel, real measured, real variance);

/* Compute the thresholds for a tick of h seconds. */
void faults_set_limits(faults *s, real h);

/* Compute `level` and `onset` of all channels. */
void faults_scan(faults *s);

/* Decide about the suspect channels, and about the motion. */
void faults_isolate(faults *s);
void faults_isolate_motion(faults *s, real h);

/* Advance the filter of the motion. Return whether a change can be a lost force. */
int faults_follow_motion(faults *s, real h, int steps);
/* Begin it again: after a fault; after a change of the load. */
void faults_forget_motion(faults *s);
void faults_accept_load(faults *s, int is_change);

#endif
