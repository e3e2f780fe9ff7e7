/* FMI 2.0: the functions for model exchange. */
#include "fmi2_types.h"

#include "../instance/model_exchange.h"
#include "fmi2_component.h"

FMI2_Export fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    return c ? (fmi2Status)continuous_enter_event_mode(instance_of(c)) : fmi2Error;
}

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

FMI2_Export fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    return c ? (fmi2Status)continuous_enter_continuous_mode(instance_of(c)) : fmi2Error;
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

FMI2_Export fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    return c ? (fmi2Status)continuous_set_states(instance_of(c), x, nx) : fmi2Error;
}

FMI2_Export fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    return c ? (fmi2Status)continuous_get_derivatives(instance_of(c), derivatives, nx) : fmi2Error;
}

FMI2_Export fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    return c ? (fmi2Status)continuous_get_indicators(instance_of(c), eventIndicators, ni) : fmi2Error;
}

FMI2_Export fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    return c ? (fmi2Status)continuous_get_states(instance_of(c), x, nx) : fmi2Error;
}

FMI2_Export fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    return c ? (fmi2Status)continuous_get_nominals(instance_of(c), x_nominal, nx) : fmi2Error;
}
