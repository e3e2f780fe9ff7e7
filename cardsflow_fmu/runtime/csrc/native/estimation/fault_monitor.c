/* Detection of faults in an estimator model. */
#include "fault_monitor.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_FITS = 6 }; /* of the pose, in a tick */

/* Values of the report; the group fault_report has as many variables. */
enum { COUNT, TIME, STATISTIC, THRESHOLD, CONFIDENCE, VALUE };

static double *array(const struct fault_monitor *s, const char *name)
{
    size_t length;
    return faults_array(s->faults, name, &length);
}

static void find_arrays(struct fault_monitor *s)
{
    size_t length;
#define OF_FAULTS(name) s->of_faults.name = array(s, #name);
#define OF_ESTIMATOR(name) s->of_estimator.name = estimator_array(s->estimator, #name, &length);
    FAULT_ARRAYS(OF_FAULTS)
    ESTIMATOR_ARRAYS(OF_ESTIMATOR)
#undef OF_FAULTS
#undef OF_ESTIMATOR
    estimator_array(s->estimator, "state", &s->states);
}

int fault_monitor_open(struct fault_monitor *s, const struct estimator_settings *settings,
                       const struct native_robot *robot, estimator *e, struct text *error)
{
    s->settings = settings, s->robot = robot, s->estimator = e;
    if (!settings->of.monitors.count)
        return 0;
    const int n = (int)robot->n, m = (int)robot->m;
    const size_t size = faults_size(n, m);
    void *memory = settings->of.watched.count == robot->m && settings->of.joints.count == robot->n && size ? malloc(size) : NULL;
    if (!memory) {
        text_set(error, size ? "native.bin does not match its estimator" : "too many muscles to detect faults");
        return 1;
    }
    s->faults = faults_open(n, m, memory);
    find_arrays(s);
#define COPY(type, name, per_item, group)                                                                     \
    memcpy(array(s, #name), settings->name, per_item * (size_t)settings->of.group.count * sizeof(double));
    FAULT_FIELDS(COPY)
#undef COPY
    memcpy(array(s, "length_noise"), settings->length_noise, robot->m * sizeof(double));
    memcpy(array(s, "encoder_noise"), settings->encoder_noise, robot->n * sizeof(double));
    if (settings->has_tensions[0]) {
        size_t length;
        memcpy(estimator_array(e, "tension_noise", &length), settings->tension_noise, robot->m * sizeof(double));
        memcpy(estimator_array(e, "tension_error", &length), settings->tension_error, robot->m * sizeof(double));
    }
    if (settings->frames[0] != 0) /* a horizon has no predicted velocity */
        memset(array(s, "load_change"), 0, robot->n * sizeof(double));
    return 0;
}

void fault_monitor_reset(struct fault_monitor *s)
{
    if (s->faults)
        faults_reset(s->faults);
}

double *fault_monitor_state(const struct fault_monitor *s, size_t *length)
{
    if (s->faults)
        return faults_array(s->faults, "remembered", length);
    double *const unused = estimator_array(s->estimator, "valid", length);
    *length = 0;
    return unused;
}

static void move(const struct fault_monitor *s)
{
    const struct native_robot *robot = s->robot;
    core_move(robot->core, s->of_faults.q);
    memcpy(s->of_faults.path_lengths, robot->lengths, robot->m * sizeof(double));
    memcpy(s->of_faults.jacobian, robot->jacobian, robot->m * robot->n * sizeof(double));
}

static void read_measurements(const struct fault_monitor *s, double h)
{
    const struct native_robot *robot = s->robot;
    const struct estimator_settings *of = s->settings;
    const double *state = s->of_estimator.state, *tension = s->of_estimator.tensions;
    const size_t tracked = of->of.tracked.count;
    double *lengths = s->of_faults.lengths, *tensions = s->of_faults.tensions, *commands = s->of_faults.commands;
    for (size_t i = 0; i < robot->m; i++)
        lengths[i] = tensions[i] = NAN, commands[i] = 0;
    for (size_t k = 0; k < of->of.lengths.count; k++) {
        const size_t i = of->measured[k];
        lengths[i] = s->of_estimator.lengths[i] - s->of_estimator.offset[i] + s->of_estimator.compliance[i] * tension[i];
        if (tracked) lengths[i] -= state[s->states - tracked + i];
        tensions[i] = of->has_tensions[0] ? tension[i] : NAN;
        commands[i] = s->out.commands[k];
    }
    memcpy(s->of_faults.encoders, s->of_estimator.encoders, robot->n * sizeof(double));
    for (size_t j = 0; j < robot->n; j++)
        s->of_faults.q[j] = state[j] + h * state[robot->n + j];
}

/* Replace the measurements that must not be used. */
static void replace_measurements(const struct fault_monitor *s)
{
    const size_t n = s->robot->n, m = s->robot->m;
    const double *usable = s->of_faults.usable, *suspect = s->of_faults.suspect;
    double *lengths = s->of_estimator.lengths, *encoders = s->of_estimator.encoders;
    double *tensions = s->of_estimator.tensions;
    for (size_t i = 0; i < m; i++) {
        if (usable[m + i] == 0 || suspect[m + i] != 0) lengths[i] = NAN;
        if (usable[2 * m + i] == 0) tensions[i] = s->of_faults.commands[i];
        if (s->of_faults.kind[i] == FAULT_BROKEN) tensions[i] = 0;
    }
    for (size_t j = 0; j < n; j++)
        if (usable[3 * m + j] == 0 || suspect[3 * m + j] != 0) encoders[j] = NAN;
}

/* Fit the pose to lengths and encoders. Return 0, or 1 if it cannot be found near the estimate. */
static int find_pose(const struct fault_monitor *s)
{
    int status = FAULTS_POSE_FAR;
    for (int k = 0; k < MAX_FITS && status == FAULTS_POSE_FAR; k++) {
        move(s);
        status = faults_pose(s->faults);
    }
    return status != FAULTS_POSE_NEAR;
}

void fault_monitor_tick(struct fault_monitor *s, double h)
{
    if (!s->faults)
        return;
    const size_t n = s->robot->n;
    read_measurements(s, h);
    memcpy(s->of_faults.velocity, s->of_estimator.state + n, n * sizeof(double));
    memcpy(s->of_faults.load, s->of_estimator.state + 2 * n, n * sizeof(double));
    s->is_near = !find_pose(s);
    if (s->is_near)
        faults_tick(s->faults, h);
    replace_measurements(s);
}

/* The acceleration without loads is that of the prediction, before the correction, which contains the last loads. */
void fault_monitor_move(struct fault_monitor *s, double h, int steps)
{
    if (!s->faults || !s->is_near || steps < 1)
        return;
    const size_t n = s->robot->n;
    const double *velocity = s->of_faults.velocity, *load = s->of_faults.load, *mobility = s->of_estimator.matrix;
    const double *predicted = s->of_estimator.state + n, *shift = s->of_estimator.shift + n;
    double *acceleration = s->of_faults.acceleration;
    for (size_t j = 0; j < n; j++) {
        acceleration[j] = (predicted[j] - shift[j] - velocity[j]) / (h * steps);
        for (size_t k = 0; k < n; k++) acceleration[j] += mobility[j * n + k] * load[k];
    }
    memcpy(s->of_faults.mobility, mobility, n * n * sizeof(double));
    memcpy(s->of_faults.acting, s->of_estimator.last_tensions, s->robot->m * sizeof(double));
    faults_move(s->faults, h * steps, steps);
}

static void write_report(const struct fault_monitor *s)
{
    const double *const values[] = {s->of_faults.time, s->of_faults.statistic, s->of_faults.threshold,
                                    s->of_faults.confidence, s->of_faults.value};
    const double *kind = s->of_faults.kind, *time = s->of_faults.time;
    const size_t parts = 3 * s->robot->m + s->robot->n;
    size_t newest = parts, count = 0;
    for (size_t p = 0; p < parts; p++) {
        if (kind[p] == 0)
            continue;
        count++;
        if (newest == parts || time[p] > time[newest]) newest = p;
    }
    s->out.report[COUNT] = (double)count;
    for (size_t k = TIME; k <= VALUE; k++)
        s->out.report[k] = newest == parts ? 0 : values[k - TIME][newest];
}

void fault_monitor_write(const struct fault_monitor *s)
{
    const struct estimator_settings *of = s->settings;
    if (!s->faults)
        return;
    const size_t m = s->robot->m;
    const double *kind = s->of_faults.kind, *bound = s->of_faults.bound;
    for (size_t k = 0; k < of->of.lengths.count; k++) {
        const size_t i = of->measured[k];
        s->out.muscles[k] = kind[i], s->out.lengths[k] = kind[m + i];
        s->out.tensions[k] = kind[2 * m + i], s->out.bounds[k] = bound[i];
    }
    for (size_t k = 0; k < of->of.encoders.count; k++)
        s->out.encoders[k] = kind[3 * m + of->encoded[k]];
    write_report(s);
}
