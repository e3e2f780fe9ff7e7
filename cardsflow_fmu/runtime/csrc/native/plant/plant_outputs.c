#include "plant_outputs.h"

#include "plant_inputs.h"

#include <string.h>

int native_plant_report_bad_command(struct model *model, size_t muscle)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->data;
    for (size_t i = 0; i < plant->settings.of.commands.count; i++)
        if (plant->settings.commanded[i] == muscle)
            text_set(&model->error, "command %.17g of %s is not finite", plant->commands[i],
                     native_port_name(native, plant->commands + i));
    return 1;
}

/* Write the tensions and states of muscles for the current commands. */
static int write_muscles(struct model *model)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->data;
    const struct plant_settings *s = &plant->settings;
    const struct native_robot *robot = &native->robot;
    const int bad = core_drive(robot->core, robot->qd, native_plant_commands(plant));
    if (bad)
        return native_plant_report_bad_command(model, (size_t)bad - 1);
    for (size_t i = 0; i < s->of.tensions.count; i++)
        plant->tensions[i] = robot->tensions[s->modelled[i]];
    for (size_t i = 0; i < s->of.far_tensions.count; i++)
        plant->far_tensions[i] = robot->far_tensions[s->rubbing[i]];
    for (size_t i = 0; i < s->of.states.count; i++)
        plant->states[i] = robot->states[s->state_order[i]];
    return 0;
}

static void write_energies(const struct plant *plant, const struct native_robot *robot)
{
    double *at = plant->energies;
    core_energies(robot->core, robot->qd);
    *at++ = robot->energies[0];
    *at++ = robot->energies[1] + plant->settings.fixed_energy[0] + robot->energies[2];
    memcpy(at, plant->work, sizeof plant->work);
    memcpy(at + WORKS, robot->momenta, 6 * sizeof(double));
}

int native_plant_write_outputs(struct model *model)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->data;
    const struct native_robot *robot = &native->robot;
    memcpy(plant->q, robot->q, robot->n * sizeof(double));
    memcpy(plant->qd, robot->qd, robot->n * sizeof(double));
    memcpy(plant->lengths, robot->lengths, robot->m * sizeof(double));
    for (size_t i = 0; i < plant->settings.of.tasks.count; i++)
        plant->tasks[i] = robot->task_values[plant->settings.task_rows[i]];
    if (plant->settings.of.energies.count)
        write_energies(plant, robot);
    return plant->settings.of.tensions.count || plant->settings.of.far_tensions.count ? write_muscles(model) : 0;
}

int native_plant_move(struct model *model)
{
    struct native_model *native = model->backend;
    const struct plant *plant = native->data;
    const int bad = core_move_checked(native->robot.core, native->robot.q, native->robot.qd);
    if (bad) {
        text_set(&model->error, "%s or its rate is not finite, or beyond 1e9",
                 native_port_name(native, plant->q + bad - 1));
        return 1;
    }
    return 0;
}
