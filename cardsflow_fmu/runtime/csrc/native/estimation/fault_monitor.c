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

static double *of_estimator(const struct fault_monitor *s, const char *name)
{
    size_t length;
    return estimator_array(s->estimator, name, &length);
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
#define COPY(type, name, per_item, group)                                                                     \
    memcpy(array(s, #name), settings->name, per_item * (size_t)settings->of.group.count * sizeof(double));
    FAULT_FIELDS(COPY)
#undef COPY
    memcpy(array(s, "length_noise"), settings->length_noise, robot->m * sizeof(double));
    memcpy(array(s, "encoder_noise"), settings->encoder_noise, robot->n * sizeof(double));
    if (settings->has_tensions[0]) {
        memcpy(of_estimator(s, "tension_noise"), settings->tension_noise, robot->m * sizeof(double));
        memcpy(of_estimator(s, "tension_error"), settings->tension_error, robot->m * sizeof(double));
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
    double *const unused = of_estimator(s, "valid");
    *length = 0;
    return unused;
}

static void move(const struct fault_monitor *s)
{
    const struct native_robot *robot = s->robot;
    core_move(robot->core, array(s, "q"));
    memcpy(array(s, "path_lengths"), robot->lengths, robot->m * sizeof(double));
    memcpy(array(s, "jacobian"), robot->jacobian, robot->m * robot->n * sizeof(double));
}

static void read_measurements(const struct fault_monitor *s, double h)
{
    const struct native_robot *robot = s->robot;
    const struct estimator_settings *of = s->settings;
    const double *offset = of_estimator(s, "offset"), *compliance = of_estimator(s, "compliance");
    const double *length = of_estimator(s, "lengths"), *tension = of_estimator(s, "tensions");
    const double *encoder = of_estimator(s, "encoders");
    size_t states;
    const double *state = estimator_array(s->estimator, "state", &states);
    const size_t tracked = of->of.tracked.count;
    double *lengths = array(s, "lengths"), *tensions = array(s, "tensions"), *commands = array(s, "commands");
    for (size_t i = 0; i < robot->m; i++)
        lengths[i] = tensions[i] = NAN, commands[i] = 0;
    for (size_t k = 0; k < of->of.lengths.count; k++) {
        const size_t i = of->measured[k];
        lengths[i] = length[i] - offset[i] + compliance[i] * tension[i];
        if (tracked) lengths[i] -= state[states - tracked + i];
        tensions[i] = of->has_tensions[0] ? tension[i] : NAN;
        commands[i] = s->out.commands[k];
    }
    memcpy(array(s, "encoders"), encoder, robot->n * sizeof(double));
    double *q = array(s, "q");
    for (size_t j = 0; j < robot->n; j++)
        q[j] = state[j] + h * state[robot->n + j];
}

/* Replace the measurements that must not be used. */
static void replace_measurements(const struct fault_monitor *s)
{
    const size_t n = s->robot->n, m = s->robot->m;
    const double *usable = array(s, "usable"), *suspect = array(s, "suspect"), *kind = array(s, "kind");
    const double *commands = array(s, "commands");
    double *lengths = of_estimator(s, "lengths"), *encoders = of_estimator(s, "encoders");
    double *tensions = of_estimator(s, "tensions");
    for (size_t i = 0; i < m; i++) {
        if (usable[m + i] == 0 || suspect[m + i] != 0) lengths[i] = NAN;
        if (usable[2 * m + i] == 0) tensions[i] = commands[i];
        if (kind[i] == FAULT_BROKEN) tensions[i] = 0;
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
    memcpy(array(s, "velocity"), of_estimator(s, "state") + n, n * sizeof(double));
    memcpy(array(s, "load"), of_estimator(s, "state") + 2 * n, n * sizeof(double));
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
    const double *velocity = array(s, "velocity"), *load = array(s, "load"), *mobility = of_estimator(s, "matrix");
    const double *predicted = of_estimator(s, "state") + n, *shift = of_estimator(s, "shift") + n;
    double *acceleration = array(s, "acceleration");
    for (size_t j = 0; j < n; j++) {
        acceleration[j] = (predicted[j] - shift[j] - velocity[j]) / (h * steps);
        for (size_t k = 0; k < n; k++) acceleration[j] += mobility[j * n + k] * load[k];
    }
    memcpy(array(s, "mobility"), mobility, n * n * sizeof(double));
    memcpy(array(s, "acting"), of_estimator(s, "last_tensions"), s->robot->m * sizeof(double));
    faults_move(s->faults, h * steps, steps);
}

static void write_report(const struct fault_monitor *s)
{
    static const char *const NAMES[] = {"time", "statistic", "threshold", "confidence", "value"};
    const size_t parts = 3 * s->robot->m + s->robot->n;
    const double *kind = array(s, "kind"), *time = array(s, "time");
    size_t newest = parts, count = 0;
    for (size_t p = 0; p < parts; p++) {
        if (kind[p] == 0)
            continue;
        count++;
        if (newest == parts || time[p] > time[newest]) newest = p;
    }
    s->out.report[COUNT] = (double)count;
    for (size_t k = TIME; k <= VALUE; k++)
        s->out.report[k] = newest == parts ? 0 : array(s, NAMES[k - TIME])[newest];
}

void fault_monitor_write(const struct fault_monitor *s)
{
    const struct estimator_settings *of = s->settings;
    if (!s->faults)
        return;
    const size_t m = s->robot->m;
    const double *kind = array(s, "kind"), *bound = array(s, "bound");
    for (size_t k = 0; k < of->of.lengths.count; k++) {
        const size_t i = of->measured[k];
        s->out.muscles[k] = kind[i], s->out.lengths[k] = kind[m + i];
        s->out.tensions[k] = kind[2 * m + i], s->out.bounds[k] = bound[i];
    }
    for (size_t k = 0; k < of->of.encoders.count; k++)
        s->out.encoders[k] = kind[3 * m + of->encoded[k]];
    write_report(s);
}
