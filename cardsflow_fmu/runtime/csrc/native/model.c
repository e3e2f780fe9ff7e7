#include "model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double TOLERANCE = 1e-9; /* tolerance of a time in whole steps */
static const double MAX_STEPS = 100000; /* in a call, as for models in Python */

void native_close(struct native_model *native)
{
    if (!native)
        return;
    if (native->data)
        native->functions->release(native->data);
    native_robot_close(&native->robot);
    native_file_free(&native->file);
    free(native->own_values);
    free(native);
}

void native_close_model(struct model *model)
{
    native_close(model->backend);
}

double *native_values(const struct native_model *native, struct native_group group, const char *name,
                      size_t count, struct text *error)
{
    const size_t port_count = native->ports->count;
    if ((count == ANY || group.count == count) && group.first <= port_count && group.count <= port_count - group.first)
        return native->values + group.first;
    text_set(error, "native.bin does not match the variables of the FMU: it has %lu of %lu for %s from %lu on",
             (unsigned long)group.count, (unsigned long)port_count, name, (unsigned long)group.first);
    return NULL;
}

int native_reset(struct model *model)
{
    const struct native_model *native = model->backend;
    for (size_t i = 0; i < native->ports->count; i++)
        model->values[i] = native->ports->ports[i].start;
    return 0;
}

const char *native_port_name(const struct native_model *native, const double *value)
{
    return native->ports->ports[value - native->values].name;
}

size_t native_whole_steps(double time, const double *parameter, const char *label, struct model *model)
{
    const double step = *parameter;
    struct text *error = &model->error;
    const double ratio = time / step, count = floor(ratio + 0.5);
    if (count >= 1 && count <= MAX_STEPS && fabs(ratio - count) <= TOLERANCE * count)
        return (size_t)count;
    model->clock[1] = 0; /* see `step` of model.h */
    if (ratio > MAX_STEPS + 0.5) {
        text_set(error, "%.17g s is %.6g times %s, %.17g s; the maximum is %.0f; use shorter steps",
                 time, ratio, label, step, MAX_STEPS);
        return 0;
    }
    text_set(error, "%.17g s is not a whole multiple of %s, %.17g s; use a multiple, or set the parameter %s "
             "before the initialization", time, label, step, native_port_name(model->backend, parameter));
    return 0;
}

static size_t total(const size_t *sizes, size_t count)
{
    size_t sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += sizes[i];
    return sum;
}

int native_get_state(struct model *model, void **bytes, size_t *size)
{
    struct native_model *native = model->backend;
    double *parts[NATIVE_STATE_PARTS];
    size_t sizes[NATIVE_STATE_PARTS];
    const size_t count = native->functions->list_state(native, parts, sizes);
    *size = total(sizes, count) * sizeof(double);
    double *at = *bytes = malloc(*size + 1);
    if (!at) {
        text_set(&model->error, "not enough memory for the state");
        return 1;
    }
    for (size_t i = 0; i < count; at += sizes[i++])
        memcpy(at, parts[i], sizes[i] * sizeof(double));
    return 0;
}

int native_set_state(struct model *model, const void *bytes, size_t size)
{
    struct native_model *native = model->backend;
    double *parts[NATIVE_STATE_PARTS];
    size_t sizes[NATIVE_STATE_PARTS];
    const size_t count = native->functions->list_state(native, parts, sizes);
    const char *at = bytes;
    if (size != total(sizes, count) * sizeof(double)) {
        text_set(&model->error, "a state of this model does not have %lu bytes", (unsigned long)size);
        return 1;
    }
    for (size_t i = 0; i < size; i += sizeof(double)) {
        double value;
        memcpy(&value, at + i, sizeof value);
        if (!isfinite(value)) {
            text_set(&model->error, "a number of the state is not finite");
            return 1;
        }
    }
    for (size_t i = 0; i < count; at += sizes[i++] * sizeof(double))
        memcpy(parts[i], at, sizes[i] * sizeof(double));
    return native->functions->after_restore ? native->functions->after_restore(model) : 0;
}
