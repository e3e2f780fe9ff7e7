/* FMI 3.0: the functions for model exchange. */
#include "fmi3_types.h"

#include "../instance/model_exchange.h"
#include "fmi3_component.h"

FMI3_Export fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                                      fmi3String resourcePath, fmi3Boolean visible,
                                                      fmi3Boolean loggingOn,
                                                      fmi3InstanceEnvironment instanceEnvironment,
                                                      fmi3LogMessageCallback logMessage)
{
    (void)instanceName, (void)visible;
    const struct fmi3_component component = {instanceEnvironment, logMessage, NULL, fmi3False, 0, NULL};
    return fmi3_open(&component, instantiationToken, resourcePath, loggingOn, MODEL_EXCHANGE);
}

FMI3_CALL(fmi3EnterEventMode, continuous_enter_event_mode)
FMI3_CALL(fmi3EnterContinuousTimeMode, continuous_enter_continuous_mode)
FMI3_CALL(fmi3EvaluateDiscreteStates, continuous_evaluate)

FMI3_Export fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                                fmi3Boolean *terminateSimulation,
                                                fmi3Boolean *nominalsOfContinuousStatesChanged,
                                                fmi3Boolean *valuesOfContinuousStatesChanged,
                                                fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime)
{
    int changed = 0;
    if (!instance)
        return fmi3Error;
    if (!discreteStatesNeedUpdate || !terminateSimulation || !nominalsOfContinuousStatesChanged ||
        !valuesOfContinuousStatesChanged || !nextEventTimeDefined || !nextEventTime)
        return fmi3_reject(instance, STATUS_ERROR, "updateDiscreteStates: null pointer");
    const enum status status = continuous_update(fmi3_instance(instance), &changed);
    *discreteStatesNeedUpdate = *terminateSimulation = *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = changed != 0;
    *nextEventTimeDefined = fmi3False, *nextEventTime = 0;
    return (fmi3Status)status;
}

FMI3_Export fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance,
                                                   fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                                   fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    int has_event = 0;
    if (!instance)
        return fmi3Error;
    if (!enterEventMode || !terminateSimulation)
        return fmi3_reject(instance, STATUS_ERROR, "completedIntegratorStep: null pointer");
    const enum status status = continuous_complete_step(fmi3_instance(instance), &has_event);
    *enterEventMode = has_event != 0, *terminateSimulation = fmi3False;
    return (fmi3Status)status;
}

FMI3_Export fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    return instance ? (fmi3Status)continuous_set_time(fmi3_instance(instance), time) : fmi3Error;
}

#define ARRAY(name, function, type)                                                                \
    FMI3_Export fmi3Status name(fmi3Instance instance, type values[], size_t count)                \
    {                                                                                              \
        return instance ? (fmi3Status)function(fmi3_instance(instance), values, count) : fmi3Error; \
    }

ARRAY(fmi3SetContinuousStates, continuous_set_states, const fmi3Float64)
ARRAY(fmi3GetContinuousStateDerivatives, continuous_get_derivatives, fmi3Float64)
ARRAY(fmi3GetEventIndicators, continuous_get_indicators, fmi3Float64)
ARRAY(fmi3GetContinuousStates, continuous_get_states, fmi3Float64)
ARRAY(fmi3GetNominalsOfContinuousStates, continuous_get_nominals, fmi3Float64)

static fmi3Status write_count(fmi3Instance instance, size_t *to, size_t count)
{
    if (!instance)
        return fmi3Error;
    if (!to)
        return fmi3_reject(instance, STATUS_ERROR, "null pointer for a number of states or event indicators");
    *to = count;
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators)
{
    return write_count(instance, nEventIndicators,
                       instance ? fmi3_instance(instance)->model.continuous.indicator_count : 0);
}

FMI3_Export fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates)
{
    return write_count(instance, nContinuousStates,
                       instance ? fmi3_instance(instance)->model.continuous.state_count : 0);
}
