/* The estimator as a native model. Inputs: measurements; outputs: state, loads, standard deviations and
   validity. */
#include "../model.h"
#include "fault_monitor.h"

#include "../../../../../sim_dart/csrc/estimator/estimator.h"
#include "../../../../../sim_dart/csrc/tangent/transition.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define VALUES_MEMBER(name, length) double *name;
struct estimator_model {
    struct estimator_settings settings;
    ESTIMATOR_GROUPS(VALUES_MEMBER) /* the values of each group */
    estimator *estimator;
    struct fault_monitor monitor;
    void *transition, *horizon;
    double since; /* steps between the last tick and the next; negative: ticks until the first measurements */
    double *state, *deviations, *innovation, *used, *status, *is_valid;
};
#undef VALUES_MEMBER

static double *array(const struct estimator_model *s, const char *name)
{
    size_t length;
    return estimator_array(s->estimator, name, &length);
}

/* Write the estimated offsets and their standard deviations; the last ones if they are not finite. */
static void write_offsets(const struct estimator_model *s, size_t n)
{
    const size_t first = 3 * n + 6 * (size_t)s->settings.of.units.count, count = s->settings.of.found_offsets.count;
    if (!native_all_finite(s->state + first, s->settings.of.tracked.count))
        return;
    for (size_t i = 0; i < count; i++) {
        const size_t at = first + s->settings.measured[i];
        s->found_offsets[i] = s->offsets[i] + s->state[at];
        s->offset_sd[i] = s->deviations[at];
    }
}

/* Write the estimate; the last one if the current one is not finite. */
static void write_outputs(const struct estimator_model *s, size_t n)
{
    if (native_all_finite(s->state, 3 * n) && native_all_finite(s->deviations, n)) {
        memcpy(s->q, s->state, n * sizeof(double));
        memcpy(s->qd, s->state + n, n * sizeof(double));
        memcpy(s->w, s->state + 2 * n, n * sizeof(double));
        memcpy(s->sd, s->deviations, n * sizeof(double));
    }
    write_offsets(s, n);
    fault_monitor_write(&s->monitor);
    s->report[0] = s->innovation[0];
    s->report[1] = s->used[0];
    s->report[2] = s->status[0];
    s->report[3] = s->is_valid[0];
}

static int initialize(struct model *model)
{
    const struct native_model *native = model->backend;
    struct estimator_model *s = native->data;
    const size_t n = native->robot.n;
    if (!(s->step[0] > 0 && s->step[0] < 1e9)) {
        text_set(&model->error, "the estimator's step must be a positive time in s, not %.17g", s->step[0]);
        return 1;
    }
    if (!native_all_finite(s->q_start, n) || !native_all_finite(s->offsets, s->settings.of.offsets.count)) {
        text_set(&model->error, "the start of the estimator, or an offset, is not finite");
        return 1;
    }
    memcpy(array(s, "start"), s->q_start, n * sizeof(double));
    for (size_t i = 0; i < s->settings.of.offsets.count; i++)
        array(s, "offset")[s->settings.measured[i]] = s->offsets[i];
    estimator_reset(s->estimator);
    fault_monitor_reset(&s->monitor);
    s->since = -(double)s->settings.delay[0];
    write_outputs(s, n);
    return 0;
}

static void take_readings(const struct estimator_model *s, int has_moved)
{
    const struct estimator_settings *of = &s->settings;
    double *lengths = array(s, "lengths"), *tensions = array(s, "tensions"), *torques = array(s, "torques");
    double *encoders = array(s, "encoders"), *accelerometers = array(s, "accelerometer");
    for (size_t i = 0; i < of->of.lengths.count; i++) {
        lengths[of->measured[i]] = s->lengths[i];
        tensions[of->measured[i]] = s->measured_tensions[i];
    }
    for (size_t i = 0; i < of->of.measured_torques.count; i++)
        torques[of->motors[i]] = s->measured_torques[i];
    for (size_t i = 0; i < of->of.encoders.count; i++)
        encoders[of->encoded[i]] = s->encoders[i];
    memcpy(array(s, "gyroscope"), s->gyroscopes, of->of.gyroscopes.count * sizeof(double));
    /* the first measurements belong to no step, so they contain no acceleration */
    for (size_t i = 0; i < of->of.accelerometers.count; i++)
        accelerometers[i] = has_moved ? s->accelerometers[i] : NAN;
}

static int step(struct model *model)
{
    const struct native_model *native = model->backend;
    struct estimator_model *s = native->data;
    const size_t steps =
        native_whole_steps(native->clock[1], s->step, "the estimator's internal step", model);
    if (!steps)
        return 1;
    if (s->since < 0) {
        s->since += 1;
        return 0;
    }
    take_readings(s, s->since > 0);
    const int was_tracking = estimator_is_tracking((int)s->status[0]);
    if (was_tracking)
        fault_monitor_tick(&s->monitor, s->step[0] * s->since);
    const int status = estimator_tick(s->estimator, s->step[0], (int32_t)s->since);
    if (was_tracking && estimator_is_tracking(status))
        fault_monitor_move(&s->monitor, s->step[0], (int)s->since);
    s->since = (double)steps;
    write_outputs(s, native->robot.n);
    return 0;
}

static size_t list_state(struct native_model *native, double **parts, size_t *sizes)
{
    struct estimator_model *s = native->data;
    parts[0] = &s->since, sizes[0] = 1;
    parts[1] = estimator_array(s->estimator, "remembered", &sizes[1]);
    parts[2] = fault_monitor_state(&s->monitor, &sizes[2]);
    parts[3] = estimator_array(s->estimator, "remembered_frames", &sizes[3]);
    return s->horizon ? 4 : 3;
}

static int after_restore(struct model *model)
{
    const struct native_model *native = model->backend;
    struct estimator_model *s = native->data;
    write_outputs(s, native->robot.n);
    return 0;
}

static void free_estimator(void *data)
{
    struct estimator_model *s = data;
    free(s->estimator);
    free(s->monitor.faults);
    free(s->transition);
    free(s->horizon);
    free(s);
}

/* Return whether the variables of faults exist if faults are detected. */
static int has_all_faults(const struct estimator_settings *s)
{
    const size_t measured = s->of.lengths.count;
    if (!s->of.monitors.count)
        return 1;
    return s->of.commands.count == measured && s->of.muscle_faults.count == measured &&
           s->of.length_faults.count == measured && s->of.tension_faults.count == measured &&
           s->of.bounds.count == measured && s->of.encoder_faults.count == s->of.encoders.count &&
           s->of.fault_report.count == 6;
}

/* Return whether all indices are within their ranges, and all counts agree. */
static int are_sound(const struct estimator_settings *s, const struct native_robot *robot)
{
    return native_all_below(s->measured, s->of.lengths.count, robot->m) &&
           native_all_below(s->motors, s->of.measured_torques.count, robot->n) &&
           native_all_below(s->encoded, s->of.encoders.count, robot->n) && s->of.muscles.count == robot->m &&
           s->of.numbers.count == 3 * robot->n + 2 && s->of.lengths.count == s->of.measured_tensions.count &&
           s->of.lengths.count == s->of.offsets.count && has_all_faults(s) &&
           s->of.found_offsets.count == (s->of.tracked.count ? s->of.lengths.count : 0) &&
           s->of.offset_sd.count == s->of.found_offsets.count &&
           s->starts[0] >= 1 && s->starts[0] <= 100000;
}

static int use_exact_transition(struct estimator_model *s, const core *c, struct text *error)
{
    const size_t size = core_transition_size(c);
    core_transition *transition = NULL;
    if (!size) {
        text_set(error, "this C core does not support derivatives; set exact_transition = false");
        return 1;
    }
    if ((s->transition = malloc(size)) != NULL)
        transition = core_transition_open(c, s->transition);
    if (!transition) {
        text_set(error, "not enough memory for the estimator");
        return 1;
    }
    estimator_use_transition(s->estimator, core_transition_fill, transition);
    return 0;
}

static int use_horizon(struct estimator_model *s, const core *c, struct text *error)
{
    const struct estimator_settings *of = &s->settings;
    const size_t size = estimator_horizon_size(c, (int32_t)of->of.units.count, (int32_t)of->of.tracked.count,
                                               (int32_t)of->frames[0]);
    if (size && !(s->horizon = malloc(size))) {
        text_set(error, "not enough memory for the estimator");
        return 1;
    }
    if (!size || estimator_use_horizon(s->estimator, (int32_t)of->frames[0], s->horizon)) {
        text_set(error, "native.bin does not match its estimator");
        return 1;
    }
#define COPY(type, name, per_item, group)                                                                     \
    memcpy(array(s, #name), of->name, per_item * (size_t)of->of.group.count * sizeof(double));
    ESTIMATOR_HORIZON_FIELDS(COPY)
#undef COPY
    return 0;
}

static int fill(struct model *model, struct native_model *native, struct text *error)
{
    struct estimator_model *data = native->data, *s = data;
    struct estimator_settings *of = &s->settings;
    const struct native_robot *robot = &native->robot;
    if (estimator_settings_read(of, native->file.settings, native->file.settings_size) || !are_sound(of, robot)) {
        text_set(error, "native.bin does not match its estimator");
        return 1;
    }
    const int32_t units = (int32_t)of->of.units.count, offsets = (int32_t)of->of.tracked.count;
    const size_t size = estimator_size(robot->core, units, offsets);
    void *memory = size ? malloc(size) : NULL;
    if (!memory || !(s->estimator = estimator_open(robot->core, units, of->imu_frame, offsets, memory))) {
        text_set(error, memory ? "native.bin does not match its estimator" : "not enough memory for the estimator");
        free(memory);
        return 1;
    }
#define COPY(type, name, per_item, group)                                                                     \
    memcpy(array(s, #name), of->name, per_item * (size_t)of->of.group.count * sizeof(double));
    ESTIMATOR_COPIED_FIELDS(COPY)
#undef COPY
    s->state = array(s, "state"), s->deviations = array(s, "sd"), s->innovation = array(s, "innovation");
    s->used = array(s, "used"), s->status = array(s, "status"), s->is_valid = array(s, "valid");
    if (of->frames[0] != 0 && use_horizon(s, robot->core, error))
        return 1;
    if (of->exact[0] != 0 && use_exact_transition(s, robot->core, error))
        return 1;
    const size_t n = robot->n, i = of->of.units.count;
    ESTIMATOR_GROUPS(NATIVE_PLACE)
    if (fault_monitor_open(&s->monitor, of, robot, s->estimator, error))
        return 1;
    const struct fault_variables values = {.commands = s->commands, .muscles = s->muscle_faults,
                                           .lengths = s->length_faults, .tensions = s->tension_faults,
                                           .encoders = s->encoder_faults, .bounds = s->bounds,
                                           .report = s->fault_report};
    s->monitor.out = values;
    (void)model;
    return 0;
}

const struct native_functions native_estimator = {
    .model = {.initialize = initialize, .step = step, NATIVE_FUNCTIONS},
    .size = sizeof(struct estimator_model),
    .open = fill,
    .list_state = list_state,
    .after_restore = after_restore,
    .release = free_estimator,
};
