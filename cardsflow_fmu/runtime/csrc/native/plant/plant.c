/* The plant as a native model. Inputs: commands, motor torques, loads and wrenches; outputs: positions,
 * velocities, lengths, tasks, tensions, muscle states, energies and momenta. */
#include "plant_continuous.h"
#include "plant_derivative.h"
#include "plant_inputs.h"
#include "plant_outputs.h"
#include "plant_settings.h"

#include <stdlib.h>
#include <string.h>

/* Set the tensions of cables that are broken at the current time, to the nearest step, to 0. */
static void break_cables(const struct plant *plant, size_t m)
{
    const struct plant_settings *s = &plant->settings;
    if (plant_is_continuous(plant))
        return;
    for (size_t i = 0; i < m; i++)
        plant->tension_scale[i] =
            (plant->ticks + 0.5) * plant->step[0] > s->break_time[i] ? 0 : s->tension_scale[i];
}

/* Write the outputs at q and qd of the core; in continuous time also derivatives and event indicators. */
static int show(struct model *model)
{
    const struct native_model *native = model->backend;
    if (plant_is_continuous(native->data))
        return model->continuous.functions->evaluate(model);
    return native_plant_move(model) || native_plant_write_outputs(model);
}

/* Set the muscles to the steady state of their commands. */
static int start_muscles(struct model *model)
{
    const struct native_model *native = model->backend;
    const int bad = core_start(native->robot.core, native_plant_commands(native->data));
    return bad ? native_plant_report_bad_command(model, (size_t)bad - 1) : 0;
}

static int initialize(struct model *model)
{
    struct native_model *native = model->backend;
    struct native_robot *robot = &native->robot;
    struct plant *plant = native->data;
    for (size_t j = 0; j < robot->n; j++)
        if (!(plant->q_start[j] >= robot->lower[j] && plant->q_start[j] <= robot->upper[j])) {
            text_set(&model->error, "%s, %.17g, is outside %.17g to %.17g",
                     native_port_name(native, plant->q_start + j), plant->q_start[j], robot->lower[j],
                     robot->upper[j]);
            return 1;
        }
    if (!plant_is_continuous(plant) && !(plant->step[0] > 0 && plant->step[0] < 1e9)) {
        text_set(&model->error, "the step of the plant must be a positive time in s, not %.17g", plant->step[0]);
        return 1;
    }
    plant->ticks = 0;
    memset(plant->held, 0, robot->n * sizeof *plant->held);
    memset(plant->work, 0, sizeof plant->work);
    memcpy(robot->q, plant->q_start, robot->n * sizeof(double));
    memcpy(robot->qd, plant->qd_start, robot->n * sizeof(double));
    if (core_move_checked(robot->core, robot->q, robot->qd) == 0) {
        if (core_close(robot->core, NULL, robot->q)) {
            text_set(&model->error, "the robot's loops cannot be closed from its start pose");
            return 1;
        }
        core_close_rates(robot->core, robot->qd);
        if (start_muscles(model))
            return 1;
        break_cables(plant, robot->m);
    }
    return show(model);
}

static int report_failed_step(struct model *model, int bad)
{
    struct native_model *native = model->backend;
    const struct plant *plant = native->data;
    const struct native_robot *robot = &native->robot;
    const double time = plant->ticks * plant->step[0];
    if (bad < 0)
        return native_plant_report_bad_command(model, (size_t)-bad - 1);
    if ((size_t)bad > robot->n)
        text_set(&model->error,
                 "the robot diverged at t = %.6g s: a muscle's state is not finite; use a smaller step", time);
    else
        text_set(&model->error,
                 "the robot diverged at t = %.6g s: %s is %.17g with velocity %.17g; use a smaller step or "
                 "softer gains",
                 time, native_port_name(native, plant->q + bad - 1), robot->q[bad - 1], robot->qd[bad - 1]);
    return 1;
}

/* Advance by one step of the plant with `muscle_commands`, `motor_torques` and `external_wrenches`. Return
 * the same as core_step. */
static int advance(const struct native_robot *robot, struct plant *plant)
{
    const uint32_t substeps = plant->settings.substeps[0];
    const int bad = plant->rule(robot->core, plant->muscle_commands, native_plant_torques(plant),
                                plant->step[0] / substeps, (int32_t)substeps);
    plant->ticks++;
    break_cables(plant, robot->m);
    for (size_t i = 0; !bad && i < WORKS; i++)
        plant->work[i] += robot->work[i];
    return bad;
}

static int step(struct model *model)
{
    struct native_model *native = model->backend;
    struct plant *plant = native->data;
    if (plant_is_continuous(plant)) {
        text_set(&model->error, "a plant for model exchange has no steps; build it for co-simulation");
        return 1;
    }
    const size_t steps =
        native_whole_steps(native->clock[1], plant->step, "the plant's internal step", model);
    if (!steps || native_plant_apply_inputs(model))
        return 1;
    for (size_t i = 0; i < steps; i++) {
        const int bad = advance(&native->robot, plant);
        if (bad)
            return report_failed_step(model, bad);
    }
    return native_plant_write_outputs(model);
}

static size_t list_state(struct native_model *native, double **parts, size_t *sizes)
{
    const struct native_robot *robot = &native->robot;
    struct plant *plant = native->data;
    parts[0] = &plant->ticks, sizes[0] = 1;
    parts[1] = robot->q, sizes[1] = robot->n;
    parts[2] = robot->qd, sizes[2] = robot->n;
    parts[3] = robot->states, sizes[3] = robot->s;
    parts[4] = plant->work, sizes[4] = plant->settings.of.energies.count ? WORKS : 0;
    parts[5] = plant->held, sizes[5] = plant_is_continuous(plant) ? robot->n : 0;
    return 6;
}

static int after_restore(struct model *model)
{
    const struct native_model *native = model->backend;
    break_cables(native->data, native->robot.m);
    return show(model);
}

static int open_plant(struct model *model, struct native_model *native, struct text *error)
{
    struct plant *plant = native->data;
    if (native_plant_settings(plant, native, error))
        return 1;
    if (plant_is_continuous(plant))
        native_plant_continuous_open(model);
    else
        model->internal_step = plant->step;
    return 0;
}

const struct native_functions native_plant = {
    .model = {.initialize = initialize, .step = step, .derivative = native_plant_derivative, NATIVE_FUNCTIONS},
    .size = sizeof(struct plant),
    .open = open_plant,
    .list_state = list_state,
    .after_restore = after_restore,
    .release = native_plant_free,
};
