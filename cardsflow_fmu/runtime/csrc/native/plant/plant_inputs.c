#include "plant_inputs.h"

#include <math.h>
#include <string.h>

const double *native_plant_commands(const struct plant *plant)
{
    for (size_t i = 0; i < plant->c; i++)
        plant->muscle_commands[(size_t)plant->commanded[i]] = plant->commands[i];
    return plant->muscle_commands;
}

const char *native_port_name(const struct native_model *native, const double *value)
{
    return native->ports->ports[value - native->values].name;
}

int native_plant_apply_inputs(struct model *model)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->own;
    const size_t p = native->robot.p, count = 3 * p + 6 * plant->k;
    for (size_t i = 0; i < count; i++)
        if (!isfinite(plant->loads[i])) {
            text_set(&model->error, "%s, %.17g, is not finite", native_port_name(native, plant->loads + i),
                     plant->loads[i]);
            return 1;
        }
    for (size_t i = 0; i < p; i++)
        memcpy(plant->external_wrenches + 6 * i, plant->loads + 3 * i, 3 * sizeof(double)); /* and no moment */
    memcpy(plant->external_wrenches + 6 * p, plant->wrenches, 6 * plant->k * sizeof(double));
    native_plant_commands(plant);
    return 0;
}
