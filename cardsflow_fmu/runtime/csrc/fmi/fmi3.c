/* FMI 3.0: life cycle, states of the FMU, and steps of co-simulation. */
#include "fmi3_types.h"

#include "../instance/derivative.h"
#include "../instance/instance.h"
#include "../instance/state_calls.h"
#include "fmi3_component.h"

#include <math.h>
#include <stdlib.h>

/* Common functions */

FMI3_Export const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

FMI3_Export fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn,
                                           size_t nCategories, const fmi3String categories[])
{
    if (!instance)
        return fmi3Error;
    int asked = log_asks_for_events(categories ? nCategories : 0, categories);
    fmi3_instance(instance)->log.events = loggingOn && asked == 1;
    if (asked < 0)
        return fmi3_reject(instance, STATUS_ERROR, "setDebugLogging: unknown category");
    return fmi3OK;
}

FMI3_Export fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
    fmi3Boolean earlyReturnAllowed, const fmi3ValueReference requiredIntermediateVariables[],
    size_t nRequiredIntermediateVariables, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)instanceName, (void)visible;
    (void)requiredIntermediateVariables, (void)nRequiredIntermediateVariables;
    const struct fmi3_component component = {instanceEnvironment, logMessage, intermediateUpdate,
                                             earlyReturnAllowed,  INFINITY,   NULL};
    if (eventModeUsed) {
        if (logMessage)
            logMessage(instanceEnvironment, fmi3Error, "logStatusError",
                       "instantiate: hasEventMode is false; set eventModeUsed to false");
        return NULL;
    }
    return fmi3_open(&component, instantiationToken, resourcePath, loggingOn, CO_SIMULATION);
}

FMI3_Export void fmi3FreeInstance(fmi3Instance instance)
{
    if (!instance)
        return;
    instance_close(fmi3_instance(instance));
    free(instance);
}

FMI3_Export fmi3Status fmi3EnterInitializationMode(fmi3Instance instance,
                                                   fmi3Boolean toleranceDefined,
                                                   fmi3Float64 tolerance, fmi3Float64 startTime,
                                                   fmi3Boolean stopTimeDefined,
                                                   fmi3Float64 stopTime)
{
    (void)toleranceDefined, (void)tolerance;
    if (!instance)
        return fmi3Error;
    enum status status = instance_set_up(fmi3_instance(instance), "enterInitializationMode",
                                         startTime, stopTimeDefined ? stopTime : INFINITY);
    if (status == STATUS_OK)
        status = instance_enter_initialization_mode(fmi3_instance(instance));
    return (fmi3Status)status;
}

FMI3_CALL(fmi3ExitInitializationMode, instance_exit_initialization_mode)
FMI3_CALL(fmi3Terminate, instance_terminate)
FMI3_CALL(fmi3Reset, instance_reset)

/* States */

FMI3_Export fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    return (fmi3Status)state_get(fmi3_instance(instance), FMUState);
}

FMI3_Export fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    return (fmi3Status)state_set(fmi3_instance(instance), FMUState);
}

FMI3_Export fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    (void)instance;
    return (fmi3Status)state_free(FMUState);
}

FMI3_Export fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState,
                                                  size_t *size)
{
    return (fmi3Status)state_size(fmi3_instance(instance), FMUState, size);
}

FMI3_Export fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState,
                                             fmi3Byte serializedState[], size_t size)
{
    return (fmi3Status)state_serialize(fmi3_instance(instance), FMUState, serializedState, size);
}

FMI3_Export fmi3Status fmi3DeserializeFMUState(fmi3Instance instance,
                                               const fmi3Byte serializedState[], size_t size,
                                               fmi3FMUState *FMUState)
{
    return (fmi3Status)state_deserialize(fmi3_instance(instance), serializedState, size, FMUState);
}

FMI3_Export fmi3Status fmi3GetDirectionalDerivative(
    fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
    fmi3Float64 sensitivity[], size_t nSensitivity)
{
    if (!instance)
        return fmi3Error;
    if ((nUnknowns && !unknowns) || (nKnowns && !knowns) || (nSeed && !seed) ||
        (nSensitivity && !sensitivity))
        return fmi3_reject(instance, STATUS_ERROR, "getDirectionalDerivative: null pointer");
    struct derivative_call call = {unknowns, nUnknowns, knowns,      nKnowns,
                                   seed,     nSeed,     sensitivity, nSensitivity};
    return (fmi3Status)get_directional_derivative(fmi3_instance(instance), &call);
}

/* Co-simulation */

/* Inform the importer about a completed internal step; it may get variables in the callback. Return whether
 * the step ends here, because the importer requests a time before the end of the next internal step. */
static int update(void *context, double time, double next)
{
    struct fmi3_component *component = context;
    const fmi3Boolean can_return = component->may_return_early && next > time;
    fmi3Boolean early_return_requested = fmi3False;
    double early_return_time = time;
    component->intermediate_update(component->environment, time, fmi3False, fmi3True, fmi3True, can_return,
                                   &early_return_requested, &early_return_time);
    if (early_return_requested)
        component->return_time = early_return_time;
    return can_return && component->return_time < next - 1e-6 * (next - time);
}

FMI3_Export fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint,
                                  fmi3Float64 communicationStepSize,
                                  fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                  fmi3Boolean *eventHandlingNeeded,
                                  fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn,
                                  fmi3Float64 *lastSuccessfulTime)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!instance)
        return fmi3Error;
    if (!eventHandlingNeeded || !terminateSimulation || !earlyReturn || !lastSuccessfulTime)
        return fmi3_reject(instance, STATUS_ERROR, "doStep: null pointer");
    struct fmi3_component *component = instance;
    const struct step_observer observer = {update, component};
    component->return_time = INFINITY;
    enum status status = instance_step(component->instance, currentCommunicationPoint, communicationStepSize,
                                       component->intermediate_update ? &observer : NULL);
    *eventHandlingNeeded = *terminateSimulation = fmi3False;
    *lastSuccessfulTime = component->instance->time;
    *earlyReturn = status == STATUS_OK && *lastSuccessfulTime < currentCommunicationPoint + communicationStepSize;
    return (fmi3Status)status;
}
