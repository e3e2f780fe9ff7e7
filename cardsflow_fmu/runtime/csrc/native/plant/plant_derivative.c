/* Exact directional derivatives of a native plant. Over a step of the preferred length: of the outputs at
 * the end by inputs, positions, velocities and muscle states at the start of the step. At the start: of the
 * outputs by commands and the start state. In model exchange: of outputs, state derivatives and event
 * indicators by inputs and states. */
#include "plant_derivative.h"

#include "../../../../../sim_dart/csrc/tangent/tangent.h"
#include "plant_inputs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if HAS_CORE_TANGENT

/* A direction: change of all quantities at the start of a step; later, at its end. */
struct change {
    double largest; /* seed: the directions are multiples of it */
    double *commands, *torques, *wrenches, *q, *qd, *states, *lengths, *tasks, *tensions, *far_tensions;
    double *qdd, *state_rates, *hold_forces;
    double power[WORKS]; /* in model exchange */
    double energies[3], work[WORKS], momenta[6]; /* as in the core; work accumulates over steps */
};

/* Return the handle, which stays open for further requests. */
static core_tangent *open_tangent(const struct native_model *native)
{
    struct plant *plant = native->data;
    const core *plain = native->robot.core;
    if (!plant->tangent && (plant->tangent = malloc(core_tangent_size(plain))))
        core_tangent_open(plain, plant->tangent);
    return plant->tangent;
}

static int open_change(struct change *change, const struct native_robot *robot, size_t externals)
{
    const size_t sizes[] = {robot->m, robot->n, 6 * externals,    robot->n, robot->n,
                            robot->s, robot->m, 3 * robot->tasks, robot->m, robot->far,
                            robot->n, robot->s, robot->n};
    double **const parts[] = {&change->commands, &change->torques, &change->wrenches,
                              &change->q,        &change->qd,      &change->states,
                              &change->lengths,  &change->tasks,   &change->tensions,
                              &change->far_tensions, &change->qdd,   &change->state_rates,
                              &change->hold_forces};
    const size_t arrays = sizeof sizes / sizeof *sizes;
    size_t count = 1;
    for (size_t i = 0; i < arrays; i++)
        count += sizes[i];
    memset(change, 0, sizeof *change);
    double *at = calloc(count, sizeof *at);
    if (!at)
        return 1;
    for (size_t i = 0; i < arrays; at += sizes[i++])
        *parts[i] = at;
    return 0;
}

/* Return whether a variable belongs to a group; `at` is its index there. */
static int is_in(struct native_group group, uint32_t variable, uint32_t *at)
{
    *at = variable - group.first;
    return variable >= group.first && *at < group.count;
}

/* Add a seed to the direction. Return nonzero if the derivative by that variable does not exist. */
static int add_seed(const struct plant_settings *s, struct change *change, uint32_t variable, double seed,
                    int is_at_start)
{
    uint32_t at;
    if (is_in(s->of.commands, variable, &at))
        change->commands[s->commanded[at]] += seed;
    else if (is_in(s->of.torques, variable, &at))
        change->torques[s->motors[at]] += seed;
    else if (is_in(s->of.loads, variable, &at))
        change->wrenches[6 * (at / 3) + at % 3] += seed;
    else if (is_in(s->of.wrenches, variable, &at))
        change->wrenches[2 * s->of.loads.count + at] += seed;
    else if (is_in(is_at_start ? s->of.q_start : s->of.q, variable, &at))
        change->q[at] += seed;
    else if (is_in(is_at_start ? s->of.qd_start : s->of.qd, variable, &at))
        change->qd[at] += seed;
    else if (!is_at_start && is_in(s->of.states, variable, &at))
        change->states[s->state_order[at]] += seed;
    else if (!is_at_start && s->of.derivatives.count && is_in(s->of.energies, variable, &at) && at >= 2 &&
             at < 2 + WORKS)
        change->work[at - 2] += seed;
    else /* the start does not depend on these */
        return !(is_at_start && (is_in(s->of.step, variable, &at) || is_in(s->of.worker_timeout, variable, &at)));
    return 0;
}

static int add_seeds(struct model *model, struct change *change, const struct derivative *request)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->data;
    const int is_at_start = native->clock[1] == 0;
    for (size_t i = 0; i < request->known_count; i++)
        change->largest = fmax(change->largest, fabs(request->seeds[i]));
    for (size_t i = 0; i < request->known_count; i++) {
        const uint32_t known = request->knowns[i];
        const double seed = change->largest > 0 ? request->seeds[i] / change->largest : 0;
        if (add_seed(&plant->settings, change, known, seed, is_at_start)) {
            text_set(&model->error, "no derivative with respect to %s %s",
                     native->ports->ports[known].name, is_at_start ? "at the start" : plant_is_continuous(plant) ? "in continuous time" : "over a step");
            return 1;
        }
    }
    return 0;
}

static void begin(const struct native_model *native, core_tangent *tangent, const struct change *change)
{
    const struct plant *plant = native->data;
    const struct native_robot *robot = &native->robot;
    core_tangent_set(tangent, TANGENT_COMMANDS, plant->muscle_commands, change->commands);
    core_tangent_set(tangent, TANGENT_Q, robot->q, change->q);
    core_tangent_set(tangent, TANGENT_QD, robot->qd, change->qd);
    core_tangent_set(tangent, TANGENT_STATES, robot->states, change->states);
    core_tangent_set(tangent, TANGENT_HELD, plant->held, change->hold_forces); /* constant: still zero */
    if (plant->settings.of.torques.count)
        core_tangent_set(tangent, TANGENT_TORQUES, plant->motor_torques, change->torques);
    core_tangent_set(tangent, TANGENT_WRENCHES, plant->external_wrenches, change->wrenches);
}

/* One step of the plant. */
static int advance_step(const struct plant *plant, core_tangent *tangent, struct change *change)
{
    const int32_t substeps = (int32_t)plant->settings.substeps[0];
    const double h = plant->step[0] / substeps;
    double work[WORKS];
    if (plant->rule == core_runge_kutta ? core_tangent_runge_kutta(tangent, h, substeps)
                                        : core_tangent_step(tangent, h, substeps))
        return 1;
    core_tangent_changes(tangent, TANGENT_WORK, work);
    for (size_t i = 0; i < WORKS; i++)
        change->work[i] += work[i];
    return 0;
}

/* Compute the state derivatives. */
static int differentiate(const struct plant *plant, core_tangent *tangent, struct change *change)
{
    if (!plant_is_continuous(plant))
        return 0;
    if (core_tangent_derivative(tangent))
        return 1;
    core_tangent_changes(tangent, TANGENT_QDD, change->qdd);
    core_tangent_changes(tangent, TANGENT_STATE_RATES, change->state_rates);
    core_tangent_changes(tangent, TANGENT_HOLD_FORCES, change->hold_forces);
    core_tangent_changes(tangent, TANGENT_WORK, change->power);
    return 0;
}

/* Advance to the time of the outputs. */
static int advance_with_tangent(struct model *model, core_tangent *tangent, struct change *change)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->data;
    const int is_at_start = native->clock[1] == 0;
    size_t steps = 0;
    if (!is_at_start && !plant_is_continuous(plant) &&
        !(steps = native_whole_steps(native->clock[1], plant->step, "the plant's internal step", model)))
        return 1;
    int failed = core_tangent_move(tangent) || (is_at_start && core_tangent_start(tangent));
    for (size_t i = 0; i < steps && !failed; i++)
        failed = advance_step(plant, tangent, change);
    failed = failed || differentiate(plant, tangent, change);
    const int is_driven = plant->settings.of.tensions.count || plant->settings.of.far_tensions.count;
    if (failed || (is_driven && core_tangent_drive(tangent))) {
        text_set(&model->error, "the step failed: an input is not finite, or the robot diverges");
        return 1;
    }
    if (plant->settings.of.energies.count)
        core_tangent_energies(tangent);
    return 0;
}

static void end(core_tangent *tangent, struct change *change)
{
    core_tangent_changes(tangent, TANGENT_Q, change->q);
    core_tangent_changes(tangent, TANGENT_QD, change->qd);
    core_tangent_changes(tangent, TANGENT_STATES, change->states);
    core_tangent_changes(tangent, TANGENT_LENGTHS, change->lengths);
    core_tangent_changes(tangent, TANGENT_TASKS, change->tasks);
    core_tangent_changes(tangent, TANGENT_TENSIONS, change->tensions);
    core_tangent_changes(tangent, TANGENT_FAR_TENSIONS, change->far_tensions);
    core_tangent_changes(tangent, TANGENT_ENERGIES, change->energies);
    core_tangent_changes(tangent, TANGENT_MOMENTA, change->momenta);
}

/* Return the change of an energy or momentum, in the order of the outputs. */
static double energy(const struct change *change, size_t at)
{
    if (at < 2)
        return at == 0 ? change->energies[0] : change->energies[1] + change->energies[2];
    return at < 2 + WORKS ? change->work[at - 2] : change->momenta[at - 2 - WORKS];
}

/* Return the change of a state derivative. */
static double derivative_change(const struct plant *plant, const struct change *change, size_t at)
{
    const size_t n = plant->settings.of.q.count, s = plant->settings.of.states.count;
    if (at < n)
        return plant->held[at] != 0 ? 0 : change->qd[at];
    if (at < 2 * n)
        return change->qdd[at - n];
    if (at < 2 * n + s)
        return change->state_rates[plant->settings.state_order[at - 2 * n]];
    return change->power[at - 2 * n - s];
}

static double indicator_change(const struct plant *plant, const struct change *change, size_t at)
{
    const size_t j = plant->settings.limited[at] / 2;
    const int is_upper = plant->settings.limited[at] % 2;
    if (plant->held[j] == (is_upper ? 1 : -1))
        return change->hold_forces[j];
    return is_upper ? -change->q[j] : change->q[j];
}

/* Return the change of an output; NaN if it is not in these groups. */
static double output_change(const struct plant *plant, const struct change *change, uint32_t unknown)
{
    const struct plant_settings *s = &plant->settings;
    uint32_t at;
    if (is_in(s->of.q, unknown, &at))
        return change->q[at];
    if (is_in(s->of.qd, unknown, &at))
        return change->qd[at];
    if (is_in(s->of.lengths, unknown, &at))
        return change->lengths[at];
    if (is_in(s->of.tasks, unknown, &at))
        return change->tasks[s->task_rows[at]];
    if (is_in(s->of.tensions, unknown, &at))
        return change->tensions[s->modelled[at]];
    if (is_in(s->of.far_tensions, unknown, &at))
        return change->far_tensions[s->rubbing[at]];
    if (is_in(s->of.states, unknown, &at))
        return change->states[s->state_order[at]];
    if (is_in(s->of.derivatives, unknown, &at))
        return derivative_change(plant, change, at);
    if (is_in(s->of.indicators, unknown, &at))
        return indicator_change(plant, change, at);
    return is_in(s->of.energies, unknown, &at) ? energy(change, at) : NAN;
}

static int write_answers(struct model *model, const struct change *change, const struct derivative *request)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->data;
    for (size_t i = 0; i < request->unknown_count; i++) {
        const uint32_t unknown = request->unknowns[i];
        request->answers[i] = change->largest * output_change(plant, change, unknown);
        if (!isfinite(request->answers[i])) {
            text_set(&model->error, "no derivative of %s", native->ports->ports[unknown].name);
            return 1;
        }
    }
    return 0;
}

static int derive(struct model *model, const struct derivative *request, core_tangent *tangent,
                  struct change *change)
{
    if (add_seeds(model, change, request) || native_plant_apply_inputs(model))
        return 1;
    begin(model->backend, tangent, change);
    if (advance_with_tangent(model, tangent, change))
        return 1;
    end(tangent, change);
    return write_answers(model, change, request);
}

int native_plant_derivative(struct model *model, const struct derivative *request)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->data;
    struct change change;
    core_tangent *tangent = open_tangent(native);
    if (!tangent || open_change(&change, &native->robot, plant->settings.of.external_points.count)) {
        text_set(&model->error, "not enough memory for a derivative");
        return 1;
    }
    const int failed = derive(model, request, tangent, &change);
    free(change.commands);
    return failed;
}

#else

int native_plant_derivative(struct model *model, const struct derivative *request)
{
    (void)request;
    text_set(&model->error, "no derivatives: this FMU was compiled by a compiler that has no complex "
             "numbers");
    return 1;
}

#endif
