/* The plant as a native model: forces and loads in; positions, velocities, lengths, tasks out.
 *
 * Values: f (m), loads (3 p); q (n), qd (n), l (m), y (k); start q (n), start qd (n), step, worker_timeout.
 * It has no settings beyond those of the robot. */
#include "native_model.h"

#include <stdlib.h>
#include <string.h>

struct plant {
    double ticks;
    double *forces, *loads, *q, *qd, *lengths, *tasks, *q_start, *qd_start, *step;
};

static void write_outputs(struct native_model *native)
{
    const struct plant *plant = native->own;
    const struct native_robot *robot = &native->robot;
    memcpy(plant->q, robot->q, robot->n * sizeof(double));
    memcpy(plant->qd, robot->qd, robot->n * sizeof(double));
    memcpy(plant->lengths, robot->lengths, robot->m * sizeof(double));
    native_robot_tasks(robot, plant->tasks);
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
    write_outputs(native);
    return 0;
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
    return go(model);
}

static int refuse_step(struct model *model, int bad)
{
    struct native_model *native = model->backend;
    const struct plant *plant = native->own;
    const struct native_robot *robot = &native->robot;
    if (bad < 0)
        text_set(&model->error, "force %.17g of %s is not finite", plant->forces[-bad - 1],
                 port_name(native, plant->forces - bad - 1));
    else
        text_set(&model->error,
                 "the robot diverged at t = %.6g s: %s is %.17g with velocity %.17g; use a smaller step or "
                 "softer gains",
                 plant->ticks * plant->step[0], port_name(native, plant->q + bad - 1), robot->q[bad - 1],
                 robot->qd[bad - 1]);
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

static int step(struct model *model)
{
    struct native_model *native = model->backend;
    struct native_robot *robot = &native->robot;
    struct plant *plant = native->own;
    const double h = plant->step[0];
    const size_t steps = native_whole_steps(native->clock[1], h, "the plant's internal step", &model->error);
    const int loaded = has_loads(native);
    if (!steps)
        return 1;
    for (size_t i = 0; i < steps; i++, plant->ticks++) {
        if (loaded)
            native_robot_load(robot, plant->loads, 1);
        const int bad = core_step(robot->core, plant->forces, loaded ? robot->load : NULL, h, 1);
        if (bad) {
            plant->ticks++;
            return refuse_step(model, bad);
        }
    }
    write_outputs(native);
    return 0;
}

static int get_state(struct model *model, void **bytes, size_t *size)
{
    struct native_model *native = model->backend;
    const struct plant *plant = native->own;
    const double *const parts[] = {&plant->ticks, native->robot.q, native->robot.qd};
    const size_t sizes[] = {1, native->robot.n, native->robot.n};
    return native_save(parts, sizes, 3, bytes, size, &model->error);
}

static int set_state(struct model *model, const void *bytes, size_t size)
{
    struct native_model *native = model->backend;
    struct plant *plant = native->own;
    double *const parts[] = {&plant->ticks, native->robot.q, native->robot.qd};
    const size_t sizes[] = {1, native->robot.n, native->robot.n};
    return native_restore(parts, sizes, 3, bytes, size, &model->error) || go(model);
}

static void close_plant(struct model *model)
{
    struct native_model *native = model->backend;
    free(native->own);
    native_close(native);
}

static const struct model_functions FUNCTIONS = {
    .initialize = initialize,
    .step = step,
    .reset = native_reset,
    .get_state = get_state,
    .set_state = set_state,
    .close = close_plant,
};

int native_plant_open(struct model *model, struct native_model *native, struct text *error)
{
    const struct native_robot *robot = &native->robot;
    const size_t n = robot->n, m = robot->m;
    if (!native_has_values(native, 2 * m + 3 * robot->p + 4 * n + robot->k + 2, error))
        return 1;
    struct plant *plant = native->own = calloc(1, sizeof *plant);
    if (!plant) {
        text_set(error, "there is no memory for the model");
        return 1;
    }
    plant->forces = native->values;
    plant->loads = plant->forces + m;
    plant->q = plant->loads + 3 * robot->p;
    plant->qd = plant->q + n;
    plant->lengths = plant->qd + n;
    plant->tasks = plant->lengths + m;
    plant->q_start = plant->tasks + robot->k;
    plant->qd_start = plant->q_start + n;
    plant->step = plant->qd_start + n;
    model->functions = &FUNCTIONS;
    return 0;
}
