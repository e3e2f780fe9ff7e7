/* Directional derivatives of a native plant, exact: over a step of the preferred length, of the outputs at
 * its end by inputs, positions and velocities at its beginning; at the start, of the outputs there by the
 * start state. */
#include "../../../sim_dart/csrc/tangent.h"
#include "native_plant.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A direction: of the inputs, and of the state, which moves along with the steps. */
struct change {
    double *forces, *loads, *q, *qd;
    double *begin; /* 2 n: the state to come back to */
    double *memory;
};

static int open_change(struct change *change, const struct native_robot *robot)
{
    const size_t n = robot->n, count = robot->m + 3 * robot->p + 4 * n;
    double *at = calloc(count + core_tangent_size(robot->core) + 1, sizeof *at);
    if (!at)
        return 1;
    change->forces = at;
    change->loads = change->forces + robot->m;
    change->q = change->loads + 3 * robot->p;
    change->qd = change->q + n;
    change->begin = change->qd + n;
    change->memory = at + count;
    return 0;
}

/* Where a value stands in a row of them; `count` if it is none of these. */
static size_t place_in(const double *value, const double *row, size_t count)
{
    return value >= row && value < row + count ? (size_t)(value - row) : count;
}

/* Adds a seed to the direction. Nonzero where there is no derivative by that value. */
static int add_seed(const struct native_model *native, struct change *change, const double *value,
                    double seed, int is_at_start)
{
    const struct plant *plant = native->own;
    const struct native_robot *robot = &native->robot;
    const size_t n = robot->n, p = 3 * robot->p;
    const double *q = is_at_start ? plant->q_start : plant->q, *qd = q + n;
    size_t at;
    if ((at = place_in(value, plant->commands, plant->c)) < plant->c)
        change->forces[(size_t)plant->commanded[at]] += seed;
    else if ((at = place_in(value, plant->loads, p)) < p)
        change->loads[at] += seed;
    else if ((at = place_in(value, q, n)) < n)
        change->q[at] += seed;
    else if ((at = place_in(value, qd, n)) < n)
        change->qd[at] += seed;
    else
        return !(is_at_start && value >= plant->step); /* of which nothing at the start depends */
    return 0;
}

static int add_seeds(struct model *model, struct change *change, const struct derivative *request)
{
    const struct native_model *native = model->backend;
    const int is_at_start = native->clock[1] == 0;
    for (size_t i = 0; i < request->known_count; i++) {
        const uint32_t known = request->knowns[i];
        if (add_seed(native, change, native->values + known, request->seeds[i], is_at_start)) {
            text_set(&model->error, "there is no derivative with respect to %s %s",
                     native->ports->ports[known].name, is_at_start ? "at the start" : "over a step");
            return 1;
        }
    }
    return 0;
}

static int go_along(struct model *model, struct change *change)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->own;
    const struct native_robot *robot = &native->robot;
    const core_tangent direction = {
        .forces = plant->told,
        .forces_change = change->forces,
        .loads = (int32_t)robot->p,
        .load_tasks = robot->points,
        .load = plant->loads,
        .load_change = change->loads,
        .q_change = change->q,
        .qd_change = change->qd,
        .memory = change->memory,
    };
    memset(plant->pushes, 0, 6 * robot->p * sizeof(double)); /* the direction has the loads */
    const double h = plant->step[0] / plant->substeps;
    const size_t steps =
        native_whole_steps(native->clock[1], plant->step[0], "the plant's internal step", &model->error);
    if (!steps)
        return 1;
    for (double i = 0; i < (double)steps * plant->substeps; i++)
        if (core_step_along(robot->core, &direction, h)) {
            text_set(&model->error, "the step leads nowhere: an input is not finite, or the robot diverges");
            return 1;
        }
    return 0;
}

static double product(const double *row, const struct change *change, size_t n)
{
    double sum = 0;
    for (size_t j = 0; j < n; j++)
        sum += row[j] * change->q[j];
    return sum;
}

/* The change of an output, the robot being where it counts; NaN if it is none of these. */
static double answer(const struct native_model *native, const struct change *change, const double *value)
{
    const struct plant *plant = native->own;
    const struct native_robot *robot = &native->robot;
    const size_t n = robot->n;
    size_t at;
    if ((at = place_in(value, plant->q, n)) < n)
        return change->q[at];
    if ((at = place_in(value, plant->qd, n)) < n)
        return change->qd[at];
    if ((at = place_in(value, plant->lengths, robot->m)) < robot->m)
        return product(robot->jacobian + at * n, change, n);
    if ((at = place_in(value, plant->tasks, robot->k)) < robot->k)
        return product(robot->task_jacobian + (size_t)robot->rows[at] * n, change, n);
    return NAN;
}

static int answer_all(struct model *model, const struct change *change, const struct derivative *request)
{
    const struct native_model *native = model->backend;
    for (size_t i = 0; i < request->unknown_count; i++) {
        request->answers[i] = answer(native, change, native->values + request->unknowns[i]);
        if (isnan(request->answers[i])) {
            text_set(&model->error, "there is no derivative of %s", native->ports->ports[request->unknowns[i]].name);
            return 1;
        }
    }
    return 0;
}

int native_plant_derivative(struct model *model, const struct derivative *request)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->own;
    const struct native_robot *robot = &native->robot;
    const size_t size = robot->n * sizeof(double);
    struct change change;
    if (open_change(&change, robot)) {
        text_set(&model->error, "there is no memory for a derivative");
        return 1;
    }
    memcpy(change.begin, robot->q, size);
    memcpy(change.begin + robot->n, robot->qd, size);
    for (size_t i = 0; i < plant->c; i++)
        plant->told[(size_t)plant->commanded[i]] = plant->commands[i];
    int failed = add_seeds(model, &change, request) || (native->clock[1] != 0 && go_along(model, &change));
    core_task_jacobian(robot->core);
    failed = failed || answer_all(model, &change, request);
    memcpy(robot->q, change.begin, size);
    memcpy(robot->qd, change.begin + robot->n, size);
    core_move(robot->core, robot->q);
    free(change.forces);
    return failed;
}
