#include "open.h"

#include "controller/controller.h"
#include "estimation/estimation_models.h"
#include "model.h"
#include "plant/plant.h"
#include "reference.h"

#include <stdlib.h>

static int fill(struct model *model, struct native_model *native, const char *resources, struct text *error)
{
    native->values = calloc(native->ports->count + 1, sizeof *native->values);
    if (!native->values) {
        text_set(error, "there is no memory for the variables");
        return 1;
    }
    model->backend = native;
    model->clock = native->clock;
    model->values = native->values;
    native_reset(model);
    if (native_file_read(&native->file, resources, error))
        return 1;
    if (native->file.kind == NATIVE_REFERENCE)
        return native_reference_open(model, native, error);
    if (native_robot_open(&native->robot, &native->file, error))
        return 1;
    static int (*const open[NATIVE_KINDS])(struct model *, struct native_model *, struct text *) = {
        [NATIVE_PLANT] = native_plant_open,
        [NATIVE_CONTROLLER] = native_controller_open,
        [NATIVE_SENSORS] = native_sensors_open,
        [NATIVE_ESTIMATOR] = native_estimator_open,
    };
    return open[native->file.kind](model, native, error);
}

int native_open(struct model *model, const struct port_table *ports, const char *resources, struct text *error)
{
    struct native_model *native = calloc(1, sizeof *native);
    if (!native) {
        text_set(error, "there is no memory for the model");
        return 1;
    }
    native->ports = ports;
    if (fill(model, native, resources, error)) {
        native_close(native);
        return 1;
    }
    return 0;
}
