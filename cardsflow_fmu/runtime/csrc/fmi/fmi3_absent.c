/* FMI 3.0: what this FMU does not have. Each function refuses; the instance stays as it is. */
#include "fmi3_types.h"

#include "fmi3_component.h"

#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

static const char NO_EVENTS[] = "this FMU has no event mode";
static const char NO_CLOCKS[] = "this FMU has no clocks";
static const char NO_STRUCTURE[] = "this FMU has no structural parameters";
static const char NO_STATES[] = "this FMU is for co-simulation, not for model exchange";
static const char NO_DEPENDENCIES[] = "this FMU does not tell dependencies of elements";
static const char NO_ADJOINTS[] = "this FMU has no adjoint derivatives";
static const char NO_OUTPUT_DERIVATIVES[] = "this FMU has no output derivatives";

FMI3_Export fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName,
                                                      fmi3String instantiationToken,
                                                      fmi3String resourcePath, fmi3Boolean visible,
                                                      fmi3Boolean loggingOn,
                                                      fmi3InstanceEnvironment instanceEnvironment,
                                                      fmi3LogMessageCallback logMessage)
{
    if (logMessage)
        logMessage(instanceEnvironment, fmi3Error, log_category(STATUS_ERROR),
                   "this FMU is for co-simulation only");
    return NULL;
}

FMI3_Export fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
    fmi3LockPreemptionCallback lockPreemption, fmi3UnlockPreemptionCallback unlockPreemption)
{
    if (logMessage)
        logMessage(instanceEnvironment, fmi3Error, log_category(STATUS_ERROR),
                   "this FMU is for co-simulation only");
    return NULL;
}

FMI3_Export fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_EVENTS);
}

FMI3_Export fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance,
                                                           fmi3ValueReference valueReference,
                                                           size_t *nDependencies)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_DEPENDENCIES);
}

FMI3_Export fmi3Status fmi3GetVariableDependencies(fmi3Instance instance,
                                                   fmi3ValueReference dependent,
                                                   size_t elementIndicesOfDependent[],
                                                   fmi3ValueReference independents[],
                                                   size_t elementIndicesOfIndependents[],
                                                   fmi3DependencyKind dependencyKinds[],
                                                   size_t nDependencies)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_DEPENDENCIES);
}

FMI3_Export fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance,
                                                const fmi3ValueReference unknowns[],
                                                size_t nUnknowns, const fmi3ValueReference knowns[],
                                                size_t nKnowns, const fmi3Float64 seed[],
                                                size_t nSeed, fmi3Float64 sensitivity[],
                                                size_t nSensitivity)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_ADJOINTS);
}

FMI3_Export fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_STRUCTURE);
}

FMI3_Export fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_STRUCTURE);
}

FMI3_Export fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance,
                                              const fmi3ValueReference valueReferences[],
                                              size_t nValueReferences, fmi3Float64 intervals[],
                                              fmi3IntervalQualifier qualifiers[])
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_CLOCKS);
}

FMI3_Export fmi3Status fmi3GetIntervalFraction(fmi3Instance instance,
                                               const fmi3ValueReference valueReferences[],
                                               size_t nValueReferences, fmi3UInt64 counters[],
                                               fmi3UInt64 resolutions[],
                                               fmi3IntervalQualifier qualifiers[])
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_CLOCKS);
}

FMI3_Export fmi3Status fmi3GetShiftDecimal(fmi3Instance instance,
                                           const fmi3ValueReference valueReferences[],
                                           size_t nValueReferences, fmi3Float64 shifts[])
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_CLOCKS);
}

FMI3_Export fmi3Status fmi3GetShiftFraction(fmi3Instance instance,
                                            const fmi3ValueReference valueReferences[],
                                            size_t nValueReferences, fmi3UInt64 counters[],
                                            fmi3UInt64 resolutions[])
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_CLOCKS);
}

FMI3_Export fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance,
                                              const fmi3ValueReference valueReferences[],
                                              size_t nValueReferences,
                                              const fmi3Float64 intervals[])
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_CLOCKS);
}

FMI3_Export fmi3Status fmi3SetIntervalFraction(fmi3Instance instance,
                                               const fmi3ValueReference valueReferences[],
                                               size_t nValueReferences, const fmi3UInt64 counters[],
                                               const fmi3UInt64 resolutions[])
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_CLOCKS);
}

FMI3_Export fmi3Status fmi3SetShiftDecimal(fmi3Instance instance,
                                           const fmi3ValueReference valueReferences[],
                                           size_t nValueReferences, const fmi3Float64 shifts[])
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_CLOCKS);
}

FMI3_Export fmi3Status fmi3SetShiftFraction(fmi3Instance instance,
                                            const fmi3ValueReference valueReferences[],
                                            size_t nValueReferences, const fmi3UInt64 counters[],
                                            const fmi3UInt64 resolutions[])
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_CLOCKS);
}

FMI3_Export fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_EVENTS);
}

FMI3_Export fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance,
                                                fmi3Boolean *discreteStatesNeedUpdate,
                                                fmi3Boolean *terminateSimulation,
                                                fmi3Boolean *nominalsOfContinuousStatesChanged,
                                                fmi3Boolean *valuesOfContinuousStatesChanged,
                                                fmi3Boolean *nextEventTimeDefined,
                                                fmi3Float64 *nextEventTime)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_EVENTS);
}

FMI3_Export fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_STATES);
}

FMI3_Export fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance,
                                                   fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                                   fmi3Boolean *enterEventMode,
                                                   fmi3Boolean *terminateSimulation)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_STATES);
}

FMI3_Export fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_STATES);
}

FMI3_Export fmi3Status fmi3SetContinuousStates(fmi3Instance instance,
                                               const fmi3Float64 continuousStates[],
                                               size_t nContinuousStates)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_STATES);
}

FMI3_Export fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance,
                                                         fmi3Float64 derivatives[],
                                                         size_t nContinuousStates)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_STATES);
}

FMI3_Export fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[],
                                              size_t nEventIndicators)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_STATES);
}

FMI3_Export fmi3Status fmi3GetContinuousStates(fmi3Instance instance,
                                               fmi3Float64 continuousStates[],
                                               size_t nContinuousStates)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_STATES);
}

FMI3_Export fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance,
                                                         fmi3Float64 nominals[],
                                                         size_t nContinuousStates)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_STATES);
}

FMI3_Export fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance,
                                                      size_t *nEventIndicators)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_STATES);
}

FMI3_Export fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance,
                                                       size_t *nContinuousStates)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_STATES);
}

FMI3_Export fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_EVENTS);
}

FMI3_Export fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance,
                                                const fmi3ValueReference valueReferences[],
                                                size_t nValueReferences, const fmi3Int32 orders[],
                                                fmi3Float64 values[], size_t nValues)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_OUTPUT_DERIVATIVES);
}

FMI3_Export fmi3Status fmi3ActivateModelPartition(fmi3Instance instance,
                                                  fmi3ValueReference clockReference,
                                                  fmi3Float64 activationTime)
{
    return fmi3_refuse(instance, STATUS_ERROR, NO_CLOCKS);
}
