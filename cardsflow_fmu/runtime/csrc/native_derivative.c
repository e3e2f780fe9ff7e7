/* Directional derivatives of a native plant, exact: over a step of the preferred length, of the outputs at
 * its end by inputs, positions, velocities and states of muscles at its beginning; at the start, of the
 * outputs there by commands and the start state. */
#include "../../../sim_dart/csrc/along.h"
#include "../../../sim_dart/csrc/along/support.h"
#include "native_plant.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if HAS_ALONG

/* A direction: of all that a step begins with; later, of all that it ends with. */
struct change {
    double largest; /* seed: the directions are multiples of it */
    double *commands, *pushes, *q, *qd, *states, *lengths, *tasks, *tensions;
    double energies[3], work[3], momenta[6]; /* as of the core; work adds up over steps */
};

/* It stays open for further questions. */
static core_along *open_along(const struct native_model *native)
{
    struct plant *plant = native->own;
    const core *plain = native->robot.core;
    if (!plant->along && (plant->along = malloc(core_along_size(plain))))
        core_along_open(plain, plant->along);
    return plant->along;
}

static int open_change(struct change *change, const struct native_robot *robot, size_t pushes)
{
    const size_t sizes[] = {robot->m, 6 * pushes, robot->n,         robot->n,
                            robot->s, robot->m,   3 * robot->tasks, robot->m};
    double **const parts[] = {&change->commands, &change->pushes,  &change->q,     &change->qd,
                              &change->states,   &change->lengths, &change->tasks, &change->tensions};
    size_t count = 1;
    for (size_t i = 0; i < 8; i++)
        count += sizes[i];
    memset(change, 0, sizeof *change);
    double *at = calloc(count, sizeof *at);
    if (!at)
        return 1;
    for (size_t i = 0; i < 8; at += sizes[i++])
        *parts[i] = at;
    return 0;
}

/* Where a value stands in a row of them; `count` if it is none of these. */
static size_t place_in(const double *value, const double *row, size_t count)
{
    return value >= row && value < row + count ? (size_t)(value - row) : count;
}

/* Adds a seed to the direction. Nonzero where there is no derivative by that value. */
static int add_seed(const struct native_model *native, const struct change *change, const double *value,
                    double seed, int is_at_start)
{
    const struct plant *plant = native->own;
    const struct native_robot *robot = &native->robot;
    const size_t n = robot->n, p = 3 * robot->p;
    const double *q = is_at_start ? plant->q_start : plant->q, *qd = q + n;
    size_t at;
    if ((at = place_in(value, plant->commands, plant->c)) < plant->c)
        change->commands[(size_t)plant->commanded[at]] += seed;
    else if ((at = place_in(value, plant->loads, p)) < p)
        change->pushes[6 * (at / 3) + at % 3] += seed;
    else if ((at = place_in(value, plant->wrenches, 6 * plant->k)) < 6 * plant->k)
        change->pushes[6 * robot->p + at] += seed;
    else if ((at = place_in(value, q, n)) < n)
        change->q[at] += seed;
    else if ((at = place_in(value, qd, n)) < n)
        change->qd[at] += seed;
    else if (!is_at_start && (at = place_in(value, plant->states, plant->s)) < plant->s)
        change->states[(size_t)plant->order[at]] += seed;
    else
        return !(is_at_start && value >= plant->step); /* of which nothing at the start depends */
    return 0;
}

static int add_seeds(struct model *model, struct change *change, const struct derivative *request)
{
    const struct native_model *native = model->backend;
    const int is_at_start = native->clock[1] == 0;
    for (size_t i = 0; i < request->known_count; i++)
        change->largest = fmax(change->largest, fabs(request->seeds[i]));
    for (size_t i = 0; i < request->known_count; i++) {
        const uint32_t known = request->knowns[i];
        const double seed = change->largest > 0 ? request->seeds[i] / change->largest : 0;
        if (add_seed(native, change, native->values + known, seed, is_at_start)) {
            text_set(&model->error, "there is no derivative with respect to %s %s",
                     native->ports->ports[known].name, is_at_start ? "at the start" : "over a step");
            return 1;
        }
    }
    return 0;
}

static void begin(const struct native_model *native, core_along *along, const struct change *change)
{
    const struct plant *plant = native->own;
    const struct native_robot *robot = &native->robot;
    core_along_set(along, ALONG_COMMANDS, plant->told, change->commands);
    core_along_set(along, ALONG_Q, robot->q, change->q);
    core_along_set(along, ALONG_QD, robot->qd, change->qd);
    core_along_set(along, ALONG_STATES, robot->states, change->states);
    core_along_set(along, ALONG_PUSHES, plant->pushes, change->pushes);
}

/* One step of the plant. */
static int go_step(const struct plant *plant, core_along *along, struct change *change)
{
    const double h = plant->step[0] / plant->substeps;
    const int32_t substeps = (int32_t)plant->substeps;
    double work[3];
    if (plant->rule == core_runge_kutta ? core_along_runge_kutta(along, h, substeps)
                                        : core_along_step(along, h, substeps))
        return 1;
    core_along_changes(along, ALONG_WORK, work);
    for (size_t i = 0; i < 3; i++)
        change->work[i] += work[i];
    return 0;
}

/* To where the answers are. */
static int go_along(struct model *model, core_along *along, struct change *change)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->own;
    const int is_at_start = native->clock[1] == 0;
    size_t steps = 0;
    if (!is_at_start && !(steps = native_whole_steps(native->clock[1], plant->step[0],
                                                     "the plant's internal step", &model->error)))
        return 1;
    int failed = core_along_move(along) || (is_at_start && core_along_start(along));
    for (size_t i = 0; i < steps && !failed; i++)
        failed = go_step(plant, along, change);
    if (failed || (plant->t && core_along_drive(along))) {
        text_set(&model->error, "the step leads nowhere: an input is not finite, or the robot diverges");
        return 1;
    }
    if (plant->books)
        core_along_energies(along);
    return 0;
}

static void end(core_along *along, struct change *change)
{
    core_along_changes(along, ALONG_Q, change->q);
    core_along_changes(along, ALONG_QD, change->qd);
    core_along_changes(along, ALONG_STATES, change->states);
    core_along_changes(along, ALONG_LENGTHS, change->lengths);
    core_along_changes(along, ALONG_TASKS, change->tasks);
    core_along_changes(along, ALONG_TENSIONS, change->tensions);
    core_along_changes(along, ALONG_ENERGIES, change->energies);
    core_along_changes(along, ALONG_MOMENTA, change->momenta);
}

/* Of one of the books, in the order of the outputs. */
static double book(const struct change *change, size_t at)
{
    if (at < 2)
        return at == 0 ? change->energies[0] : change->energies[1] + change->energies[2];
    return at < 5 ? change->work[at - 2] : change->momenta[at - 5];
}

/* The change of an output; NaN if it is none of these. */
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
        return change->lengths[at];
    if ((at = place_in(value, plant->tasks, robot->k)) < robot->k)
        return change->tasks[(size_t)robot->rows[at]];
    if ((at = place_in(value, plant->tensions, plant->t)) < plant->t)
        return change->tensions[(size_t)plant->modelled[at]];
    if ((at = place_in(value, plant->states, plant->s)) < plant->s)
        return change->states[(size_t)plant->order[at]];
    if ((at = place_in(value, plant->energies, plant->books)) < plant->books)
        return book(change, at);
    return NAN;
}

static int answer_all(struct model *model, const struct change *change, const struct derivative *request)
{
    const struct native_model *native = model->backend;
    for (size_t i = 0; i < request->unknown_count; i++) {
        const uint32_t unknown = request->unknowns[i];
        request->answers[i] = change->largest * answer(native, change, native->values + unknown);
        if (!isfinite(request->answers[i])) {
            text_set(&model->error, "there is no derivative of %s", native->ports->ports[unknown].name);
            return 1;
        }
    }
    return 0;
}

static int derive(struct model *model, const struct derivative *request, core_along *along,
                  struct change *change)
{
    if (add_seeds(model, change, request) || native_plant_tell(model))
        return 1;
    begin(model->backend, along, change);
    if (go_along(model, along, change))
        return 1;
    end(along, change);
    return answer_all(model, change, request);
}

int native_plant_derivative(struct model *model, const struct derivative *request)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->own;
    struct change change;
    core_along *along = open_along(native);
    if (!along || open_change(&change, &native->robot, native->robot.p + plant->k)) {
        text_set(&model->error, "there is no memory for a derivative");
        return 1;
    }
    const int failed = derive(model, request, along, &change);
    free(change.commands);
    return failed;
}

#else

int native_plant_derivative(struct model *model, const struct derivative *request)
{
    (void)request;
    text_set(&model->error, "there are no derivatives: this FMU was compiled by a compiler that has no complex "
                            "numbers");
    return 1;
}

#endif
