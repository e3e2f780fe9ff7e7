/* The plant as a native model: commands and loads in; positions, velocities, lengths, tasks, tensions and
 * states of muscles out.
 *
 * Values: commands (c), loads (3 p); q (n), qd (n), l (m), y (k), tensions (t), states (s); start q (n),
 * start qd (n), step, worker_timeout.
 *
 * Settings, after those of the robot: steps of the integrator in one of the plant; the muscles that take
 * commands, whose tensions are outputs, and which of all muscles' states each output is: of each a number,
 * then the indices. */
#include "native_plant.h"

#include <stdlib.h>
#include <string.h>

/* What every muscle is told, in the order of the robot. */
static const double *told(const struct plant *plant)
{
    for (size_t i = 0; i < plant->c; i++)
        plant->told[(size_t)plant->commanded[i]] = plant->commands[i];
    return plant->told;
}

static int refuse_command(struct model *model, size_t muscle)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->own;
    for (size_t i = 0; i < plant->c; i++)
        if ((size_t)plant->commanded[i] == muscle)
            text_set(&model->error, "command %.17g of %s is not finite", plant->commands[i],
                     native->ports->ports[plant->commands + i - native->values].name);
    return 1;
}

/* The outputs at the core's state, with the commands as they stand. */
static int write_outputs(struct model *model)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->own;
    const struct native_robot *robot = &native->robot;
    memcpy(plant->q, robot->q, robot->n * sizeof(double));
    memcpy(plant->qd, robot->qd, robot->n * sizeof(double));
    memcpy(plant->lengths, robot->lengths, robot->m * sizeof(double));
    native_robot_tasks(robot, plant->tasks);
    if (!plant->t)
        return 0;
    const int bad = core_drive(robot->core, robot->qd, told(plant));
    if (bad)
        return refuse_command(model, (size_t)bad - 1);
    for (size_t i = 0; i < plant->t; i++)
        plant->tensions[i] = robot->tensions[(size_t)plant->modelled[i]];
    for (size_t i = 0; i < plant->s; i++)
        plant->states[i] = robot->states[(size_t)plant->order[i]];
    return 0;
}

static const char *port_name(const struct native_model *native, const double *value)
{
    return native->ports->ports[value - native->values].name;
}

/* Moves the core to its q and qd, and shows where it is. */
static int go(struct model *model)
{
    struct native_model *native = model->backend;
    const struct plant *plant = native->own;
    const int bad = core_move_checked(native->robot.core, native->robot.q, native->robot.qd);
    if (bad) {
        text_set(&model->error, "%s or its rate is not finite, or beyond 1e9",
                 port_name(native, plant->q + bad - 1));
        return 1;
    }
    return write_outputs(model);
}

/* Muscles that have been at rest with their commands for long. */
static int start_muscles(struct model *model)
{
    const struct native_model *native = model->backend;
    const int bad = core_start(native->robot.core, told(native->own));
    return bad ? refuse_command(model, (size_t)bad - 1) : 0;
}

static int initialize(struct model *model)
{
    struct native_model *native = model->backend;
    struct native_robot *robot = &native->robot;
    struct plant *plant = native->own;
    for (size_t j = 0; j < robot->n; j++)
        if (!(plant->q_start[j] >= robot->lower[j] && plant->q_start[j] <= robot->upper[j])) {
            text_set(&model->error, "%s, %.17g, is outside %.17g to %.17g",
                     port_name(native, plant->q_start + j), plant->q_start[j], robot->lower[j],
                     robot->upper[j]);
            return 1;
        }
    if (!(plant->step[0] > 0 && plant->step[0] < 1e9)) {
        text_set(&model->error, "the plant's step must be a positive time in s, not %.17g", plant->step[0]);
        return 1;
    }
    plant->ticks = 0;
    memcpy(robot->q, plant->q_start, robot->n * sizeof(double));
    memcpy(robot->qd, plant->qd_start, robot->n * sizeof(double));
    if (core_move_checked(robot->core, robot->q, robot->qd) == 0 && start_muscles(model))
        return 1;
    return go(model);
}

static int refuse_step(struct model *model, int bad)
{
    struct native_model *native = model->backend;
    const struct plant *plant = native->own;
    const struct native_robot *robot = &native->robot;
    const double time = plant->ticks * plant->step[0];
    if (bad < 0)
        return refuse_command(model, (size_t)-bad - 1);
    if ((size_t)bad > robot->n)
        text_set(&model->error,
                 "the robot diverged at t = %.6g s: a muscle's state is no number; use a smaller step", time);
    else
        text_set(&model->error,
                 "the robot diverged at t = %.6g s: %s is %.17g with velocity %.17g; use a smaller step or "
                 "softer gains",
                 time, port_name(native, plant->q + bad - 1), robot->q[bad - 1], robot->qd[bad - 1]);
    return 1;
}

static int has_loads(const struct native_model *native)
{
    const struct plant *plant = native->own;
    for (size_t i = 0; i < 3 * native->robot.p; i++)
        if (plant->loads[i] != 0)
            return 1;
    return 0;
}

/* One step of the plant. */
static int advance(struct native_robot *robot, const struct plant *plant, int is_loaded)
{
    for (double i = 0; i < plant->substeps; i++) {
        if (is_loaded)
            native_robot_load(robot, plant->loads, 1);
        const int bad = core_step(robot->core, plant->told, is_loaded ? robot->load : NULL,
                                  plant->step[0] / plant->substeps, 1);
        if (bad)
            return bad;
    }
    return 0;
}

static int step(struct model *model)
{
    struct native_model *native = model->backend;
    struct plant *plant = native->own;
    const size_t steps =
        native_whole_steps(native->clock[1], plant->step[0], "the plant's internal step", &model->error);
    const int is_loaded = has_loads(native);
    if (!steps)
        return 1;
    told(plant);
    for (size_t i = 0; i < steps; i++) {
        const int bad = advance(&native->robot, plant, is_loaded);
        plant->ticks++;
        if (bad)
            return refuse_step(model, bad);
    }
    return write_outputs(model);
}

static int get_state(struct model *model, void **bytes, size_t *size)
{
    const struct native_model *native = model->backend;
    const struct native_robot *robot = &native->robot;
    const double *const parts[] = {&((const struct plant *)native->own)->ticks, robot->q, robot->qd,
                                   robot->states};
    const size_t sizes[] = {1, robot->n, robot->n, robot->s};
    return native_save(parts, sizes, 4, bytes, size, &model->error);
}

static int set_state(struct model *model, const void *bytes, size_t size)
{
    struct native_model *native = model->backend;
    const struct native_robot *robot = &native->robot;
    double *const parts[] = {&((struct plant *)native->own)->ticks, robot->q, robot->qd, robot->states};
    const size_t sizes[] = {1, robot->n, robot->n, robot->s};
    return native_restore(parts, sizes, 4, bytes, size, &model->error) || go(model);
}

static void close_plant(struct model *model)
{
    struct native_model *native = model->backend;
    free(((struct plant *)native->own)->told);
    free(((struct plant *)native->own)->along);
    free(native->own);
    native_close(native);
}

static const struct model_functions FUNCTIONS = {
    .initialize = initialize,
    .step = step,
    .reset = native_reset,
    .get_state = get_state,
    .set_state = set_state,
    .derivative = native_plant_derivative,
    .close = close_plant,
};

/* Nonzero where the settings do not fit the robot. */
static int take_settings(struct plant *plant, const struct native_robot *robot, struct native_file *file)
{
    const double *substeps = native_file_take(file, 1);
    if (!substeps || !(substeps[0] >= 1 && substeps[0] <= 1e6) || substeps[0] != (double)(size_t)substeps[0])
        return 1;
    plant->substeps = substeps[0];
    return native_file_take_indices(file, robot->m, &plant->c, &plant->commanded) ||
           native_file_take_indices(file, robot->m, &plant->t, &plant->modelled) ||
           native_file_take_indices(file, robot->s, &plant->s, &plant->order) || file->settings_count;
}

static void place_values(struct plant *plant, const struct native_model *native)
{
    const struct native_robot *robot = &native->robot;
    plant->commands = native->values;
    plant->loads = plant->commands + plant->c;
    plant->q = plant->loads + 3 * robot->p;
    plant->qd = plant->q + robot->n;
    plant->lengths = plant->qd + robot->n;
    plant->tasks = plant->lengths + robot->m;
    plant->tensions = plant->tasks + robot->k;
    plant->states = plant->tensions + plant->t;
    plant->q_start = plant->states + plant->s;
    plant->qd_start = plant->q_start + robot->n;
    plant->step = plant->qd_start + robot->n;
}

int native_plant_open(struct model *model, struct native_model *native, struct text *error)
{
    const struct native_robot *robot = &native->robot;
    struct plant *plant = calloc(1, sizeof *plant);
    double *told = calloc(robot->m + 1, sizeof *told);
    int failed = !plant || !told;
    if (failed)
        text_set(error, "there is no memory for the model");
    else if ((failed = take_settings(plant, robot, &native->file)))
        text_set(error, "native.bin does not fit its plant");
    else
        failed = !native_has_values(native,
                                    plant->c + 3 * robot->p + 4 * robot->n + robot->m + robot->k +
                                        plant->t + plant->s + 2,
                                    error);
    if (failed) {
        free(plant);
        free(told);
        return 1;
    }
    native->own = plant;
    plant->told = told;
    place_values(plant, native);
    model->functions = &FUNCTIONS;
    return 0;
}
