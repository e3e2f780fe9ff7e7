#include "model_exchange.h"

#include <math.h>
#include <string.h>

enum { EVALUABLE = INITIALIZATION_MODE | EVENT_MODE | CONTINUOUS_MODE | TERMINATED };

static const struct continuous_functions *functions_of(const struct instance *instance)
{
    return instance->model.continuous.functions;
}

/* Report a call of model exchange. The state of the instance, which is for co-simulation, does not change. */
static void reject(struct instance *instance, const char *call)
{
    struct text text = {NULL};
    text_set(&text, "%s: this FMU is for co-simulation, not for model exchange", call);
    log_status(&instance->log, STATUS_ERROR, text_get(&text));
    text_free(&text);
}

/* Return whether the call is allowed now, for an array of `count` elements instead of `expected`; otherwise
 * the instance fails. */
static int allows(struct instance *instance, const char *call, unsigned life_cycles, const double *array,
                  size_t count, size_t expected)
{
    if (!functions_of(instance)) {
        reject(instance, call);
        return 0;
    }
    if (!instance_allows(instance, call, life_cycles))
        return 0;
    if (count == expected && (array || !count))
        return 1;
    instance_fail(instance, "%s: an array of %lu elements is required, not %lu", call,
                  (unsigned long)expected, array || !count ? (unsigned long)count : 0ul);
    return 0;
}

static int allows_call(struct instance *instance, const char *call, unsigned life_cycles)
{
    return allows(instance, call, life_cycles, NULL, 0, 0);
}

enum status continuous_set_time(struct instance *instance, double time)
{
    if (!allows_call(instance, "setTime", EVENT_MODE | CONTINUOUS_MODE))
        return STATUS_ERROR;
    if (!isfinite(time) || time < instance->start_time)
        return instance_fail(instance, "setTime: %.12g s is not a time after the start, %.12g s", time,
                             instance->start_time);
    instance->time = time; /* the model depends on time through its inputs only */
    return STATUS_OK;
}

enum status continuous_set_states(struct instance *instance, const double *states, size_t count)
{
    if (!allows(instance, "setContinuousStates", EVENT_MODE | CONTINUOUS_MODE, states, count,
                instance->model.continuous.state_count))
        return STATUS_ERROR;
    functions_of(instance)->set_states(&instance->model, states);
    instance->evaluation_is_due = 1;
    return STATUS_OK;
}

enum status continuous_get_states(struct instance *instance, double *states, size_t count)
{
    if (!allows(instance, "getContinuousStates", EVALUABLE, states, count,
                instance->model.continuous.state_count))
        return STATUS_ERROR;
    const enum status status = instance->initialization_is_due ? instance_update(instance) : STATUS_OK;
    if (status == STATUS_OK)
        functions_of(instance)->get_states(&instance->model, states);
    return status;
}

/* Copy an array that an evaluation computes. */
static enum status get(struct instance *instance, const char *call, const double *from, size_t expected,
                       double *values, size_t count)
{
    if (!allows(instance, call, EVALUABLE, values, count, expected))
        return STATUS_ERROR;
    const enum status status = instance_update(instance);
    if (status == STATUS_OK && count)
        memcpy(values, from, count * sizeof *values);
    return status;
}

enum status continuous_get_derivatives(struct instance *instance, double *derivatives, size_t count)
{
    const struct continuous *parts = &instance->model.continuous;
    return get(instance, "getDerivatives", parts->derivatives, parts->state_count, derivatives, count);
}

enum status continuous_get_indicators(struct instance *instance, double *indicators, size_t count)
{
    const struct continuous *parts = &instance->model.continuous;
    return get(instance, "getEventIndicators", parts->indicators, parts->indicator_count, indicators, count);
}

enum status continuous_get_nominals(struct instance *instance, double *nominals, size_t count)
{
    const struct continuous *parts = &instance->model.continuous;
    if (!allows(instance, "getNominalsOfContinuousStates", EVALUABLE, nominals, count, parts->state_count))
        return STATUS_ERROR;
    memcpy(nominals, parts->nominals, count * sizeof *nominals);
    return STATUS_OK;
}

enum status continuous_complete_step(struct instance *instance, int *has_event)
{
    *has_event = 0;
    if (!allows_call(instance, "completedIntegratorStep", CONTINUOUS_MODE))
        return STATUS_ERROR;
    const enum status status = instance_update(instance);
    if (status == STATUS_OK)
        *has_event = functions_of(instance)->has_event(&instance->model);
    return status;
}

enum status continuous_enter_event_mode(struct instance *instance)
{
    if (!allows_call(instance, "enterEventMode", EVENT_MODE | CONTINUOUS_MODE))
        return STATUS_ERROR;
    instance->life_cycle = EVENT_MODE;
    return STATUS_OK;
}

enum status continuous_enter_continuous_mode(struct instance *instance)
{
    if (!allows_call(instance, "enterContinuousTimeMode", EVENT_MODE | CONTINUOUS_MODE))
        return STATUS_ERROR;
    instance->life_cycle = CONTINUOUS_MODE;
    return STATUS_OK;
}

enum status continuous_evaluate(struct instance *instance)
{
    return allows_call(instance, "evaluateDiscreteStates", EVALUABLE) ? instance_update(instance) : STATUS_ERROR;
}

enum status continuous_update(struct instance *instance, int *changed)
{
    *changed = 0;
    if (!allows_call(instance, "newDiscreteStates", EVENT_MODE))
        return STATUS_ERROR;
    if (functions_of(instance)->update(&instance->model, changed))
        return instance_fail(instance, "event at %.12g s: %s", instance->time,
                             text_get(&instance->model.error));
    instance->evaluation_is_due = 0;
    return STATUS_OK;
}
