/* The estimator of sim_dart/csrc with a model of the robot, in static memory: q and qd from lengths and
 * tensions, if robot.h contains an estimator. make_controller.py writes its settings. */
#ifndef ROBOT_ESTIMATOR_H
#define ROBOT_ESTIMATOR_H

#include "../../sim_dart/csrc/estimator/estimator.h"
#include "robot_law.h"

#if ESTIMATED
static estimator *observer;
static uint64_t observed_memory[OBSERVED_MEMORY / 8], observer_memory[OBSERVER_MEMORY / 8];

static real *observed(const char *name)
{
    size_t length;
    return estimator_array(observer, name, &length);
}

static int open_estimator(void)
{
    if (core_size(OBSERVED, sizeof OBSERVED, NULL, 0) > sizeof observed_memory)
        return 0;
    core *robot_core = core_open(OBSERVED, sizeof OBSERVED, observed_memory);
    if (!robot_core || estimator_size(robot_core, 0, OFFSETS) > sizeof observer_memory ||
        !(observer = estimator_open(robot_core, 0, NULL, OFFSETS, observer_memory)))
        return 0;
    for (size_t i = 0; i < sizeof OBSERVER_SETTINGS / sizeof *OBSERVER_SETTINGS; i++)
        memcpy(observed(OBSERVER_SETTINGS[i].name), OBSERVER_SETTINGS[i].values,
               OBSERVER_SETTINGS[i].count * sizeof(real));
    estimator_reset(observer);
    return 1;
}

/* Copy the measurements of a frame, q, qd, l, f, to the estimator; those of a missed frame are NaN. Only
 * joints with an encoder are used. */
static void take_readings(const double *state, int is_new)
{
    const double *lengths = state + 2 * COORDINATES, *tensions = lengths + MUSCLES;
    for (size_t i = 0; i < MUSCLES; i++) {
        observed("lengths")[i] = is_new ? (real)lengths[i] : NAN;
        observed("tensions")[i] = (real)tensions[i];
    }
    for (size_t j = 0; j < COORDINATES; j++)
        observed("encoders")[j] = is_new && ENCODED[j] ? (real)state[j] : NAN;
}

/* Replace q and qd of a frame by the estimate, and return the estimated load; return whether the estimate is
 * valid. The first measurements are those at the start: steps is 0. */
static int estimate(double *state, int is_new, int32_t steps, real *load)
{
    take_readings(state, is_new);
    estimator_tick(observer, (real)STEP, steps);
    for (size_t j = 0; j < 2 * COORDINATES; j++)
        state[j] = (double)observed("state")[j];
    memcpy(load, observed("state") + 2 * COORDINATES, COORDINATES * sizeof(real));
    return observed("valid")[0] != 0;
}
#else
static int open_estimator(void) { return 1; }

static int estimate(double *state, int is_new, int32_t steps, real *load)
{
    (void)state, (void)is_new, (void)steps, (void)load;
    return 1;
}
#endif

#endif
