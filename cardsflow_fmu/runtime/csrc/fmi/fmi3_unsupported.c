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
static const char NO_DEPENDENCIES[] = "this FMU does not provide dependencies of elements";
static const char NO_ADJOINTS[] = "this FMU has no adjoint derivatives";
static const char NO_OUTPUT_DERIVATIVES[] = "this FMU has no output derivatives";

FMI3_Export fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
    fmi3LockPreemptionCallback lockPreemption, fmi3UnlockPreemptionCallback unlockPreemption)
{
    if (logMessage)
        logMessage(instanceEnvironment, fmi3Error, log_category(STATUS_ERROR),
                   "this FMU is not for scheduled execution");
    return NULL;
}

#define ABSENT(why, ...)                                                                                       \
    FMI3_Export fmi3Status __VA_ARGS__                                                                        \
    {                                                                                                         \
        return fmi3_reject(instance, STATUS_ERROR, why);                                                      \
    }

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
ABSENT(NO_EVENTS, fmi3EnterStepMode(fmi3Instance instance))
ABSENT(NO_OUTPUT_DERIVATIVES, fmi3GetOutputDerivatives(fmi3Instance instance,
       const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3Int32 orders[],
       fmi3Float64 values[], size_t nValues))
ABSENT(NO_CLOCKS, fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clockReference,
       fmi3Float64 activationTime))
