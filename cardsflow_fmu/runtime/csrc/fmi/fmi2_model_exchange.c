/* FMI 2.0: the functions for model exchange. */
#include "fmi2_types.h"

#include "../instance/model_exchange.h"
#include "fmi2_component.h"

FMI2_CALL(fmi2EnterEventMode, continuous_enter_event_mode)
FMI2_CALL(fmi2EnterContinuousTimeMode, continuous_enter_continuous_mode)

FMI2_Export fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo)
{
    int changed = 0;
    if (!c || !eventInfo)
        return fmi2Error;
    const enum status status = continuous_update(instance_of(c), &changed);
    const fmi2EventInfo info = {fmi2False, fmi2False, fmi2False, changed, fmi2False, 0};
    *eventInfo = info;
    return (fmi2Status)status;
}

FMI2_Export fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                                   fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!c || !enterEventMode || !terminateSimulation)
        return fmi2Error;
    *terminateSimulation = fmi2False;
    return (fmi2Status)continuous_complete_step(instance_of(c), enterEventMode);
}

FMI2_Export fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    return c ? (fmi2Status)continuous_set_time(instance_of(c), time) : fmi2Error;
}

#define ARRAY(name, function, type)                                                                \
    FMI2_Export fmi2Status name(fmi2Component c, type values[], size_t count)                      \
    {                                                                                              \
        return c ? (fmi2Status)function(instance_of(c), values, count) : fmi2Error;                \
    }

ARRAY(fmi2SetContinuousStates, continuous_set_states, const fmi2Real)
ARRAY(fmi2GetDerivatives, continuous_get_derivatives, fmi2Real)
ARRAY(fmi2GetEventIndicators, continuous_get_indicators, fmi2Real)
ARRAY(fmi2GetContinuousStates, continuous_get_states, fmi2Real)
ARRAY(fmi2GetNominalsOfContinuousStates, continuous_get_nominals, fmi2Real)
