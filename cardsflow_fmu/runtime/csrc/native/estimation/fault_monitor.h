/* Detection of faults in an estimator model: connects the measurements to controllers/csrc/faults. */
#ifndef NATIVE_FAULT_MONITOR_H
#define NATIVE_FAULT_MONITOR_H

#include "../../../../../controllers/csrc/faults/faults.h"
#include "../../../../../sim_dart/csrc/estimator/estimator.h"
#include "../model.h"

/* Variables of the model; see cosim/signals/reaction.py. */
struct fault_variables {
    double *commands, *muscles, *lengths, *tensions, *encoders, *bounds, *report;
};

/* Arrays of the monitor and of the estimator that are used in each tick; see faults_array and estimator_array. */
#define FAULT_ARRAYS(ARRAY)                                                                                     \
    ARRAY(lengths) ARRAY(encoders) ARRAY(tensions) ARRAY(commands) ARRAY(q) ARRAY(path_lengths) ARRAY(jacobian) \
    ARRAY(acceleration) ARRAY(mobility) ARRAY(acting) ARRAY(velocity) ARRAY(load) ARRAY(kind) ARRAY(time)       \
    ARRAY(statistic) ARRAY(threshold) ARRAY(confidence) ARRAY(value) ARRAY(usable) ARRAY(suspect) ARRAY(bound)
#define ESTIMATOR_ARRAYS(ARRAY)                                                                                 \
    ARRAY(offset) ARRAY(compliance) ARRAY(lengths) ARRAY(tensions) ARRAY(encoders) ARRAY(state) ARRAY(matrix)   \
    ARRAY(shift) ARRAY(last_tensions)

struct fault_monitor {
    faults *faults; /* NULL if faults are not detected */
    const struct estimator_settings *settings;
    const struct native_robot *robot;
    estimator *estimator;
#define MEMBER(name) double *name;
    struct { FAULT_ARRAYS(MEMBER) } of_faults;
    struct { ESTIMATOR_ARRAYS(MEMBER) } of_estimator;
#undef MEMBER
    size_t states;
    int is_near; /* whether the pose was found in this tick */
    struct fault_variables out;
};

/* Return 0, or nonzero with a message. The monitor has no faults if the settings contain none. */
int fault_monitor_open(struct fault_monitor *s, const struct estimator_settings *settings,
                       const struct native_robot *robot, estimator *e, struct text *error);
void fault_monitor_reset(struct fault_monitor *s);

/* Test the measurements in the arrays of the estimator, whose last tick was h seconds ago. Measurements of suspect
   sensors and of sensors with faults are replaced, so that the estimator does not use them. */
void fault_monitor_tick(struct fault_monitor *s, double h);

/* Test the motion after the tick of the estimator, in steps of h. */
void fault_monitor_move(struct fault_monitor *s, double h, int steps);

/* Return the internal state and its length; 0 numbers without detection. */
double *fault_monitor_state(const struct fault_monitor *s, size_t *length);

void fault_monitor_write(const struct fault_monitor *s);

#endif
