/* Simulated sensors as a native model. Inputs: true state, tensions and torques; outputs: measurements. */
#include "../model.h"

#include "../../../../../sim_dart/csrc/sensors/sensors.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define VALUES_MEMBER(name, length) double *name;
struct sensors_model {
    struct sensors_settings settings;
    SENSORS_GROUPS(VALUES_MEMBER) /* the values of each group */
    sensors *sensors;
    double *true_q, *true_qd, *true_tensions, *true_torques, *channels;
};
#undef VALUES_MEMBER

static double *array(const struct sensors_model *s, const char *name, size_t *length)
{
    return sensors_array(s->sensors, name, length);
}

/* Write the measurements of a group; its channels begin with `first`, and `indices` are their indices in the
   kind. */
static void write_group(const struct sensors_model *s, double *values, size_t count, size_t first, const uint32_t *items)
{
    for (size_t i = 0; i < count; i++)
        values[i] = s->channels[first + (items ? items[i] : i)];
}

static void write_outputs(const struct sensors_model *s, const struct native_robot *robot)
{
    const size_t n = robot->n, m = robot->m, units = s->settings.of.units.count;
    const struct sensors_settings *of = &s->settings;
    write_group(s, s->lengths, of->of.lengths.count, 0, of->measured);
    write_group(s, s->measured_tensions, of->of.lengths.count, m, of->measured);
    write_group(s, s->measured_torques, of->of.torques.count, 2 * m, of->motors);
    write_group(s, s->encoders, of->of.encoders.count, 2 * m + n, of->encoded);
    write_group(s, s->gyroscopes, 3 * units, 2 * m + 2 * n, NULL);
    write_group(s, s->accelerometers, 3 * units, 2 * m + 2 * n + 3 * units, NULL);
}

static int initialize(struct model *model)
{
    const struct native_model *native = model->backend;
    const struct sensors_model *s = native->data;
    size_t length;
    sensors_reset(s->sensors);
    array(s, "readings", &length);
    memset(s->channels, 0, length * sizeof(double));
    write_outputs(s, &native->robot);
    return 0;
}

static int step(struct model *model)
{
    const struct native_model *native = model->backend;
    const struct sensors_model *s = native->data;
    const struct sensors_settings *of = &s->settings;
    memcpy(s->true_q, s->q, native->robot.n * sizeof(double));
    memcpy(s->true_qd, s->qd, native->robot.n * sizeof(double));
    for (size_t i = 0; i < of->of.tensions.count; i++)
        s->true_tensions[of->measured[i]] = s->tensions[i];
    for (size_t i = 0; i < of->of.torques.count; i++)
        s->true_torques[of->motors[i]] = s->torques[i];
    const int bad = sensors_read(s->sensors, native->clock[1]);
    if (bad) {
        text_set(&model->error, "sensors: %s or its rate is not finite",
                 native->ports->ports[s->q - native->values + bad - 1].name);
        return 1;
    }
    write_outputs(s, &native->robot);
    return 0;
}

static size_t list_state(struct native_model *native, double **parts, size_t *sizes)
{
    parts[0] = array(native->data, "remembered", sizes);
    return 1;
}

static void release(void *data)
{
    struct sensors_model *s = data;
    free(s->sensors);
    free(s);
}

/* Return whether all indices are within their ranges, and all counts agree. */
static int are_sound(const struct sensors_settings *s, const struct native_robot *robot)
{
    return native_all_below(s->measured, s->of.lengths.count, robot->m) &&
           native_all_below(s->motors, s->of.torques.count, robot->n) &&
           native_all_below(s->encoded, s->of.encoders.count, robot->n) &&
           s->of.channels.count == 2 * robot->m + 2 * robot->n + 6 * s->of.units.count &&
           s->of.muscles.count == robot->m && s->of.lengths.count == s->of.tensions.count &&
           s->of.lengths.count == s->of.measured_tensions.count &&
           s->of.torques.count == s->of.measured_torques.count && s->delay[0] <= INT32_MAX;
}

static int fill(struct model *model, struct native_model *native, struct text *error)
{
    struct sensors_model *data = native->data, *s = data;
    struct sensors_settings *of = &s->settings;
    const struct native_robot *robot = &native->robot;
    if (sensors_settings_read(of, native->file.settings, native->file.settings_size) || !are_sound(of, robot)) {
        text_set(error, "native.bin does not match its sensors");
        return 1;
    }
    const int32_t units = (int32_t)of->of.units.count, delay = (int32_t)of->delay[0];
    const size_t size = sensors_size(robot->core, units, delay);
    void *memory = size ? malloc(size) : NULL;
    if (!memory || !(s->sensors = sensors_open(robot->core, units, of->imu_frame, delay, memory))) {
        free(memory);
        text_set(error, memory ? "native.bin does not match its sensors" : "not enough memory for the sensors");
        return 1;
    }
    size_t length;
#define COPY(type, name, per_item, group)                                                                     \
    memcpy(array(s, #name, &length), of->name, per_item * (size_t)of->of.group.count * sizeof(double));
    SENSORS_COPIED_FIELDS(COPY)
#undef COPY
    s->true_q = array(s, "q", &length), s->true_qd = array(s, "qd", &length);
    s->true_tensions = array(s, "tensions", &length), s->true_torques = array(s, "torques", &length);
    s->channels = array(s, "readings", &length);
    const size_t n = robot->n, i = of->of.units.count;
    SENSORS_GROUPS(NATIVE_PLACE)
    (void)model;
    return 0;
}

const struct native_functions native_sensors = {
    .model = {.initialize = initialize, .step = step, NATIVE_FUNCTIONS},
    .size = sizeof(struct sensors_model),
    .open = fill,
    .list_state = list_state,
    .release = release,
};
