#include "plant_inputs.h"

#include <math.h>
#include <string.h>

const double *native_plant_commands(const struct plant *plant)
{
    for (size_t i = 0; i < plant->settings.of.commands.count; i++)
        plant->muscle_commands[plant->settings.commanded[i]] = plant->commands[i];
    return plant->muscle_commands;
}

const double *native_plant_torques(const struct plant *plant)
{
    return plant->settings.of.torques.count ? plant->motor_torques : NULL;
}

static int check_finite(struct model *model, const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i])) {
            text_set(&model->error, "%s, %.17g, is not finite", native_port_name(model->backend, values + i),
                     values[i]);
            return 1;
        }
    return 0;
}

int native_plant_apply_inputs(struct model *model)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->data;
    const size_t loads = plant->settings.of.loads.count, wrenches = plant->settings.of.wrenches.count;
    const size_t torques = plant->settings.of.torques.count;
    if (check_finite(model, plant->torques, torques) || check_finite(model, plant->loads, loads) || check_finite(model, plant->wrenches, wrenches))
        return 1;
    for (size_t i = 0; i < loads; i += 3)
        memcpy(plant->external_wrenches + 2 * i, plant->loads + i, 3 * sizeof(double)); /* without moments */
    memcpy(plant->external_wrenches + 2 * loads, plant->wrenches, wrenches * sizeof(double));
    for (size_t i = 0; i < torques; i++)
        plant->motor_torques[plant->settings.motors[i]] = plant->torques[i];
    native_plant_commands(plant);
    return 0;
}
