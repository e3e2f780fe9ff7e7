/* The estimator of sim_dart/csrc on the robot as it knows it, in static memory: q and qd from lengths and tensions,
 * where robot.h says that there is one. make_controller.py writes its settings. */
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
    core *own = core_open(OBSERVED, sizeof OBSERVED, observed_memory);
    if (!own || estimator_size(own, 0) > sizeof observer_memory ||
        !(observer = estimator_open(own, 0, NULL, observer_memory)))
        return 0;
    for (size_t i = 0; i < sizeof OBSERVER_SETTINGS / sizeof *OBSERVER_SETTINGS; i++)
        memcpy(observed(OBSERVER_SETTINGS[i].name), OBSERVER_SETTINGS[i].values,
               OBSERVER_SETTINGS[i].count * sizeof(real));
    estimator_reset(observer);
    return 1;
}

/* Readings of a frame, q, qd, l, f, into the estimator; those of a missed one are no numbers. Only joints with an
 * encoder are looked at. */
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

/* Puts the estimate in the place of a frame's q and qd, and gives the load that it finds; whether it is valid. The
 * first readings are those of the start: steps is 0. */
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
