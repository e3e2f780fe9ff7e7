#include "plant_settings.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int has_friction(const struct native_robot *robot)
{
    const double *friction = core_coordinates(robot->core, "friction");
    for (size_t j = 0; j < robot->n; j++)
        if (friction[j] != 0)
            return 1;
    return 0;
}

/* Return whether the variables and fields of model exchange are valid: either all exist, or none. */
static int is_sound_in_time(const struct plant_settings *s, const struct native_robot *robot)
{
    const size_t states = 2 * robot->n + robot->s + (s->of.energies.count ? WORKS : 0);
    for (size_t i = 0; i < s->of.derivatives.count; i++)
        if (!(s->nominals[i] > 0 && isfinite(s->nominals[i])))
            return 0;
    if (!s->of.derivatives.count)
        return s->of.step.count == 1 && s->of.worker_timeout.count == 1 && s->of.indicators.count == 0;
    return s->of.derivatives.count == states && s->of.states.count == robot->s && !has_friction(robot) &&
           !robot->far && native_all_below(s->limited, s->of.indicators.count, 2 * robot->n);
}

/* Return whether all indices are within their ranges, and all numbers are valid. */
static int are_sound(const struct plant_settings *s, const struct native_robot *robot)
{
    const uint32_t points = s->of.loads.count / 3 + s->of.wrenches.count / 6, integrator = s->integrator[0];
    for (size_t i = 0; i < 3 * (size_t)s->of.external_points.count; i++)
        if (!isfinite(s->external_point[i]))
            return 0;
    if (s->of.lengths.count != robot->m)
        return 0;
    for (size_t i = 0; i < robot->m; i++)
        if (!(s->tension_scale[i] >= 0 && isfinite(s->tension_scale[i]) && s->break_time[i] >= 0))
            return 0;
    return is_sound_in_time(s, robot) && native_all_below(s->load_rows, s->of.loads.count, 3 * robot->tasks) &&
           native_all_below(s->task_rows, s->of.tasks.count, 3 * robot->tasks) &&
           native_all_below(s->commanded, s->of.commands.count, robot->m) &&
           native_all_below(s->motors, s->of.torques.count, robot->n) &&
           native_all_below(s->modelled, s->of.tensions.count, robot->m) &&
           native_all_below(s->rubbing, s->of.far_tensions.count, robot->far) &&
           native_all_below(s->state_order, s->of.states.count, robot->s) && s->of.loads.count % 3 == 0 &&
           s->of.wrenches.count % 6 == 0 && s->of.external_points.count == points &&
           (s->of.energies.count == 0 || s->of.energies.count == ENERGIES) && s->substeps[0] >= 1 &&
           s->substeps[0] <= 1000000 && isfinite(s->fixed_energy[0]) &&
           /* Runge-Kutta does not support friction */
           (integrator == 0 || (integrator == 1 && !has_friction(robot) && !robot->far));
}

int native_plant_settings(struct plant *data, struct native_model *native, struct text *error)
{
    struct plant *plant = data;
    const struct native_robot *robot = &native->robot;
    struct plant_settings *s = &plant->settings;
    const struct native_group *points = &s->of.external_points;
    if (plant_settings_read(s, native->file.settings, native->file.settings_size) || !are_sound(s, robot)) {
        text_set(error, "native.bin does not match its plant");
        return 1;
    }
    plant->rule = s->integrator[0] ? core_runge_kutta : core_step;
    plant->muscle_commands = calloc(robot->m + 1, sizeof *plant->muscle_commands);
    plant->external_wrenches = calloc(6 * (size_t)points->count + 1, sizeof *plant->external_wrenches);
    plant->motor_torques = calloc(robot->n + 1, sizeof *plant->motor_torques);
    plant->before_event = calloc(2 * robot->n + 1, sizeof *plant->before_event);
    if (!plant->muscle_commands || !plant->external_wrenches || !plant->motor_torques || !plant->before_event) {
        text_set(error, "not enough memory for the model");
        return 1;
    }
    size_t length;
    plant->tension_scale = core_array(robot->core, "tension_scale", &length);
    memcpy(plant->tension_scale, s->tension_scale, robot->m * sizeof(double));
    plant->held = core_array(robot->core, "held", &length);
    plant->hold_force = core_array(robot->core, "hold_force", &length);
    plant->qdd = core_array(robot->core, "qdd", &length);
    plant->state_rates = core_array(robot->core, "law_rates", &length);
    /* the core reads these arrays in every step */
    if (core_external_wrenches(robot->core, (int32_t)points->count, s->external_frame, s->external_point,
                               plant->external_wrenches)) {
        text_set(error, "native.bin does not match its plant");
        return 1;
    }
    const size_t n = robot->n, m = robot->m;
    PLANT_GROUPS(NATIVE_PLACE)
    return 0;
}

void native_plant_free(void *data)
{
    struct plant *plant = data;
    free(plant->muscle_commands);
    free(plant->external_wrenches);
    free(plant->motor_torques);
    free(plant->before_event);
    free(plant->tangent);
    free(plant);
}
