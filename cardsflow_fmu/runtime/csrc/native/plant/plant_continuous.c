/* A native plant in continuous time. Its states are q, qd, the states of muscles, and with energies the work;
 * its events are joint limits, and gaps of loops that numerical integration has opened. */
#include "plant_continuous.h"

#include "plant_inputs.h"
#include "plant_outputs.h"

#include <math.h>
#include <string.h>

/* Gap of a loop that an event closes, in [m] or as a cosine. */
static const double MAX_GAP = 1e-8;

/* Distance beyond a limit without an event, for robots with loops: closing a loop moves a coordinate. */
static const double LOOP_TOLERANCE = 2e-7;

static void get_states(const struct model *model, double *states)
{
    const struct native_model *native = model->backend;
    const struct native_robot *robot = &native->robot;
    const struct plant *plant = native->data;
    memcpy(states, robot->q, robot->n * sizeof *states);
    memcpy(states + robot->n, robot->qd, robot->n * sizeof *states);
    states += 2 * robot->n;
    for (size_t i = 0; i < robot->s; i++)
        states[i] = robot->states[plant->settings.state_order[i]];
    if (plant->settings.of.energies.count)
        memcpy(states + robot->s, plant->work, sizeof plant->work);
}

static void set_states(struct model *model, const double *states)
{
    struct native_model *native = model->backend;
    const struct native_robot *robot = &native->robot;
    struct plant *plant = native->data;
    memcpy(robot->q, states, robot->n * sizeof *states);
    memcpy(robot->qd, states + robot->n, robot->n * sizeof *states);
    states += 2 * robot->n;
    for (size_t i = 0; i < robot->s; i++)
        robot->states[plant->settings.state_order[i]] = states[i];
    if (plant->settings.of.energies.count)
        memcpy(plant->work, states + robot->s, sizeof plant->work);
}

static void write_derivatives(const struct plant *plant, const struct native_robot *robot)
{
    double *at = plant->derivatives;
    for (size_t j = 0; j < robot->n; j++)
        *at++ = plant->held[j] != 0 ? 0 : robot->qd[j];
    memcpy(at, plant->qdd, robot->n * sizeof *at);
    at += robot->n;
    for (size_t i = 0; i < robot->s; i++)
        *at++ = plant->state_rates[plant->settings.state_order[i]];
    if (plant->settings.of.energies.count)
        memcpy(at, robot->work, sizeof plant->work);
}

static void write_indicators(const struct plant *plant, const struct native_robot *robot)
{
    for (size_t i = 0; i < plant->settings.of.indicators.count; i++) {
        const size_t j = plant->settings.limited[i] / 2;
        const int is_upper = plant->settings.limited[i] % 2;
        const double gap = is_upper ? robot->upper[j] - robot->q[j] : robot->q[j] - robot->lower[j];
        plant->indicators[i] = plant->held[j] == (is_upper ? 1 : -1) ? plant->hold_force[j] : gap;
    }
}

/* Return whether all states of muscles are finite; otherwise write a message. */
static int are_finite(struct model *model, const struct native_robot *robot)
{
    for (size_t i = 0; i < robot->s; i++)
        if (!isfinite(robot->states[i])) {
            text_set(&model->error, "a muscle's state is not finite");
            return 0;
        }
    return 1;
}

static int evaluate(struct model *model)
{
    struct native_model *native = model->backend;
    const struct native_robot *robot = &native->robot;
    const struct plant *plant = native->data;
    if (!are_finite(model, robot) || native_plant_apply_inputs(model) || native_plant_move(model))
        return 1;
    const int bad = core_derivative(robot->core, plant->muscle_commands, native_plant_torques(plant));
    if (bad)
        return native_plant_report_bad_command(model, (size_t)bad - 1);
    write_derivatives(plant, robot);
    write_indicators(plant, robot);
    return native_plant_write_outputs(model);
}

static int update(struct model *model, int *changed)
{
    struct native_model *native = model->backend;
    const struct native_robot *robot = &native->robot;
    const struct plant *plant = native->data;
    const size_t size = robot->n * sizeof(double);
    if (!are_finite(model, robot) || native_plant_apply_inputs(model) || native_plant_move(model))
        return 1;
    memcpy(plant->before_event, robot->q, size);
    memcpy(plant->before_event + robot->n, robot->qd, size);
    const int bad = core_meet_limits(robot->core, plant->muscle_commands, native_plant_torques(plant));
    if (bad)
        return native_plant_report_bad_command(model, (size_t)bad - 1);
    *changed = memcmp(plant->before_event, robot->q, size) || memcmp(plant->before_event + robot->n, robot->qd, size);
    return evaluate(model);
}

static int has_open_loop(const struct native_robot *robot)
{
    size_t closures;
    const double *gaps = core_array(robot->core, "closure_gap", &closures);
    if (closures)
        core_closures(robot->core, robot->qd);
    for (size_t k = 0; k < closures; k++)
        if (fabs(gaps[k]) > MAX_GAP)
            return 1;
    return 0;
}

/* Solvers find the zeros of event indicators; this also finds those that a solver misses because the
 * indicator was zero before. */
static int has_event(struct model *model)
{
    const struct native_model *native = model->backend;
    const struct native_robot *robot = &native->robot;
    const struct plant *plant = native->data;
    size_t closures;
    core_array(robot->core, "closure_gap", &closures);
    for (size_t i = 0; i < plant->settings.of.indicators.count; i++) {
        const size_t j = plant->settings.limited[i] / 2;
        const double outwards = plant->settings.limited[i] % 2 ? robot->qd[j] : -robot->qd[j];
        const int is_held = plant->held[j] == (plant->settings.limited[i] % 2 ? 1 : -1);
        const double beyond = is_held || !closures ? 0 : LOOP_TOLERANCE;
        if (plant->indicators[i] < -beyond && (is_held || outwards >= 0))
            return 1;
    }
    return has_open_loop(robot);
}

static const struct continuous_functions FUNCTIONS = {
    .get_states = get_states,
    .set_states = set_states,
    .evaluate = evaluate,
    .update = update,
    .has_event = has_event,
};

void native_plant_continuous_open(struct model *model)
{
    const struct native_model *native = model->backend;
    const struct plant *plant = native->data;
    model->continuous.functions = &FUNCTIONS;
    model->continuous.state_count = plant->settings.of.derivatives.count;
    model->continuous.indicator_count = plant->settings.of.indicators.count;
    model->continuous.derivatives = plant->derivatives;
    model->continuous.indicators = plant->indicators;
    model->continuous.nominals = plant->settings.nominals;
}
