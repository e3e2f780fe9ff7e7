#include "open.h"

#include "model.h"

#include <stdlib.h>

static int open_kind(struct model *model, struct native_model *native, struct text *error)
{
    static const struct native_functions *const kinds[NATIVE_KINDS] = {
        [NATIVE_PLANT] = &native_plant,
        [NATIVE_CONTROLLER] = &native_controller,
        [NATIVE_REFERENCE] = &native_reference,
        [NATIVE_SENSORS] = &native_sensors,
        [NATIVE_ESTIMATOR] = &native_estimator,
    };
    model->backend = native;
    model->clock = native->clock;
    model->values = native->values;
    native_reset(model);
    if (native->file.kind != NATIVE_REFERENCE && native_robot_open(&native->robot, &native->file, error))
        return 1;
    native->functions = kinds[native->file.kind];
    model->functions = &native->functions->model;
    native->data = calloc(1, native->functions->size);
    if (native->data)
        return native->functions->open(model, native, error);
    text_set(error, "not enough memory for the model");
    return 1;
}

static struct native_model *new_model(const struct port_table *ports, double *values, struct text *error)
{
    struct native_model *native = calloc(1, sizeof *native);
    double *allocated = native && !values ? calloc(ports->count + 1, sizeof *allocated) : NULL;
    if (!native || (!values && !allocated)) {
        text_set(error, "not enough memory for the model");
        free(native);
        return NULL;
    }
    native->ports = ports;
    native->own_values = allocated;
    native->values = values ? values : allocated;
    return native;
}

int native_open(struct model *model, const struct port_table *ports, const char *resources, struct text *error)
{
    struct native_model *native = new_model(ports, NULL, error);
    if (native && !native_file_read(&native->file, resources, error) && !open_kind(model, native, error))
        return 0;
    native_close(native);
    return 1;
}

int native_open_bytes(struct model *model, const struct port_table *ports, const void *bytes, size_t size,
                      double *values, struct text *error)
{
    struct native_model *native = new_model(ports, values, error);
    if (native && !native_file_copy(&native->file, bytes, size, error) && !open_kind(model, native, error))
        return 0;
    native_close(native);
    return 1;
}
