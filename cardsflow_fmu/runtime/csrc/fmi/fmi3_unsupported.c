/* Unsupported functions of FMI 3.0. Each of them reports an error; the state of the instance does not
   change. */
#include "fmi3_types.h"

#include "fmi3_component.h"

#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

static const char NO_EVENTS[] = "this FMU has no event mode";
static const char NO_CLOCKS[] = "this FMU has no clocks";
static const char NO_STRUCTURE[] = "this FMU has no structural parameters";
static const char NO_STATES[] = "this FMU is for co-simulation, not for model exchange";
static const char NO_DEPENDENCIES[] = "this FMU does not provide dependencies of elements";
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

#define ABSENT(why, ...)                                                                                       \
    FMI3_Export fmi3Status __VA_ARGS__                                                                        \
    {                                                                                                         \
        return fmi3_reject(instance, STATUS_ERROR, why);                                                      \
    }

ABSENT(NO_EVENTS, fmi3EnterEventMode(fmi3Instance instance))
ABSENT(NO_DEPENDENCIES, fmi3GetNumberOfVariableDependencies(fmi3Instance instance,
       fmi3ValueReference valueReference, size_t *nDependencies))
ABSENT(NO_DEPENDENCIES, fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent,
       size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
       size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[], size_t nDependencies))
ABSENT(NO_ADJOINTS, fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
       size_t nUnknowns, const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
       size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity))
ABSENT(NO_STRUCTURE, fmi3EnterConfigurationMode(fmi3Instance instance))
ABSENT(NO_STRUCTURE, fmi3ExitConfigurationMode(fmi3Instance instance))
ABSENT(NO_CLOCKS, fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
       size_t nValueReferences, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[]))
ABSENT(NO_CLOCKS, fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
       size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
       fmi3IntervalQualifier qualifiers[]))
ABSENT(NO_CLOCKS, fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
       size_t nValueReferences, fmi3Float64 shifts[]))
ABSENT(NO_CLOCKS, fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
       size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[]))
ABSENT(NO_CLOCKS, fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
       size_t nValueReferences, const fmi3Float64 intervals[]))
ABSENT(NO_CLOCKS, fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
       size_t nValueReferences, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]))
ABSENT(NO_CLOCKS, fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
       size_t nValueReferences, const fmi3Float64 shifts[]))
ABSENT(NO_CLOCKS, fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
       size_t nValueReferences, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]))
ABSENT(NO_EVENTS, fmi3EvaluateDiscreteStates(fmi3Instance instance))
ABSENT(NO_EVENTS, fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
       fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
       fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
       fmi3Float64 *nextEventTime))
ABSENT(NO_STATES, fmi3EnterContinuousTimeMode(fmi3Instance instance))
ABSENT(NO_STATES, fmi3CompletedIntegratorStep(fmi3Instance instance,
       fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *enterEventMode,
       fmi3Boolean *terminateSimulation))
ABSENT(NO_STATES, fmi3SetTime(fmi3Instance instance, fmi3Float64 time))
ABSENT(NO_STATES, fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[],
       size_t nContinuousStates))
ABSENT(NO_STATES, fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[],
       size_t nContinuousStates))
ABSENT(NO_STATES, fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[],
       size_t nEventIndicators))
ABSENT(NO_STATES, fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[],
       size_t nContinuousStates))
ABSENT(NO_STATES, fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[],
       size_t nContinuousStates))
ABSENT(NO_STATES, fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators))
ABSENT(NO_STATES, fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates))
ABSENT(NO_EVENTS, fmi3EnterStepMode(fmi3Instance instance))
ABSENT(NO_OUTPUT_DERIVATIVES, fmi3GetOutputDerivatives(fmi3Instance instance,
       const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3Int32 orders[],
       fmi3Float64 values[], size_t nValues))
ABSENT(NO_CLOCKS, fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clockReference,
       fmi3Float64 activationTime))
