/* FMI 2.0: the functions of the standard in its order, except those for model exchange. */
#include "fmi2_types.h"

#include "../instance/derivative.h"
#include "../instance/instance.h"
#include "../instance/state_calls.h"
#include "../instance/variables.h"
#include "../platform/file_uri.h"
#include "../platform/text.h"
#include "fmi2_component.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Reject a call of an unsupported function. The state of the instance does not change. */
static fmi2Status reject(fmi2Component c, enum status status, const char *text)
{
    if (c)
        log_status(&instance_of(c)->log, status, text);
    return (fmi2Status)status;
}

static void free_component(struct component *component)
{
    free(component->log.instance_name);
    free(component);
}

static struct component *new_component(const char *name, const fmi2CallbackFunctions *functions)
{
    struct component *component = calloc(1, sizeof *component);
    if (!component)
        return NULL;
    if (functions)
        component->log.callbacks = *functions;
    component->log.instance_name = text_copy(name ? name : "");
    if (component->log.instance_name)
        return component;
    free_component(component);
    return NULL;
}

static struct instance *open_at(const struct log *log, const char *guid, const char *resource_location,
                                enum interface interface)
{
    struct text error = {NULL};
    struct instance *instance = NULL;
    char *folder = resource_location ? path_from_file_uri(resource_location) : NULL;
    if (folder) {
        instance = instance_open(log, guid, folder, interface);
    } else {
        text_set(&error, "the resource location %s is not a file URI of this machine",
                 resource_location ? resource_location : "(none)");
        log_status(log, STATUS_ERROR, text_get(&error));
        text_free(&error);
    }
    free(folder);
    return instance;
}

static struct instance *open_instance(struct component *component, fmi2Type type, const char *guid,
                                      const char *resource_location, int logging_on)
{
    struct log log = {fmi2_log_write, &component->log, logging_on};
    return open_at(&log, guid, resource_location, type == fmi2CoSimulation ? CO_SIMULATION : MODEL_EXCHANGE);
}

/* Common functions */

FMI2_Export const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

FMI2_Export const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

FMI2_Export fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn,
                                           size_t nCategories, const fmi2String categories[])
{
    if (!c)
        return fmi2Error;
    int asked = log_asks_for_events(categories ? nCategories : 0, categories);
    instance_of(c)->log.events = loggingOn && asked == 1;
    return asked < 0 ? reject(c, STATUS_WARNING, "setDebugLogging: unknown category") : fmi2OK;
}

FMI2_Export fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType,
                                          fmi2String fmuGUID, fmi2String fmuResourceLocation,
                                          const fmi2CallbackFunctions *functions,
                                          fmi2Boolean visible, fmi2Boolean loggingOn)
{
    (void)visible;
    struct component *component = new_component(instanceName, functions);
    if (!component)
        return NULL;
    component->instance = open_instance(component, fmuType, fmuGUID, fmuResourceLocation, loggingOn);
    if (component->instance)
        return component;
    free_component(component);
    return NULL;
}

FMI2_Export void fmi2FreeInstance(fmi2Component c)
{
    if (!c)
        return;
    instance_close(instance_of(c));
    free_component(c);
}

FMI2_Export fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined,
                                           fmi2Real tolerance, fmi2Real startTime,
                                           fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    (void)toleranceDefined, (void)tolerance;
    if (!c)
        return fmi2Error;
    double stop = stopTimeDefined ? stopTime : INFINITY;
    return (fmi2Status)instance_set_up(instance_of(c), "setupExperiment", startTime, stop);
}

FMI2_CALL(fmi2EnterInitializationMode, instance_enter_initialization_mode)
FMI2_CALL(fmi2ExitInitializationMode, instance_exit_initialization_mode)
FMI2_CALL(fmi2Terminate, instance_terminate)
FMI2_CALL(fmi2Reset, instance_reset)

/* Variables */

/* Return whether the arrays are valid; otherwise the instance fails. */
static int has_arrays(fmi2Component c, const void *vr, size_t nvr, const void *value)
{
    if (!c)
        return 0;
    if (nvr == 0 || (vr && value))
        return 1;
    instance_fail(instance_of(c), "null pointer in access to a variable");
    return 0;
}

#define PRESENT(type, port_type, representation)                                                   \
    FMI2_Export fmi2Status fmi2Get##type(fmi2Component c, const fmi2ValueReference vr[],           \
                                         size_t nvr, fmi2##type value[])                           \
    {                                                                                              \
        static const struct access access = {"get" #type, port_type, representation};              \
        const struct variables variables = {vr, nvr, nvr};                                         \
        if (!has_arrays(c, vr, nvr, value))                                                        \
            return fmi2Error;                                                                      \
        return (fmi2Status)get_variables(instance_of(c), &access, variables, value);               \
    }                                                                                              \
    FMI2_Export fmi2Status fmi2Set##type(fmi2Component c, const fmi2ValueReference vr[],           \
                                         size_t nvr, const fmi2##type value[])                     \
    {                                                                                              \
        static const struct access access = {"set" #type, port_type, representation};              \
        const struct variables variables = {vr, nvr, nvr};                                         \
        if (!has_arrays(c, vr, nvr, value))                                                        \
            return fmi2Error;                                                                      \
        return (fmi2Status)set_variables(instance_of(c), &access, variables, value);               \
    }

PRESENT(Real, PORT_REAL, AS_DOUBLE)
PRESENT(Boolean, PORT_BOOLEAN, AS_INT)

/* Reject access to integers or strings, which no FMU has. */
static fmi2Status no_variables_of_type(fmi2Component c, size_t nvr)
{
    if (c && nvr == 0)
        return fmi2OK;
    if (!c)
        return fmi2Error;
    return (fmi2Status)instance_fail(instance_of(c), "this FMU has no integer or string variables");
}

#define ABSENT(type)                                                                               \
    FMI2_Export fmi2Status fmi2Get##type(fmi2Component c, const fmi2ValueReference vr[],           \
                                         size_t nvr, fmi2##type value[])                           \
    {                                                                                              \
        (void)vr, (void)value;                                                                     \
        return no_variables_of_type(c, nvr);                                                       \
    }                                                                                              \
    FMI2_Export fmi2Status fmi2Set##type(fmi2Component c, const fmi2ValueReference vr[],           \
                                         size_t nvr, const fmi2##type value[])                     \
    {                                                                                              \
        (void)vr, (void)value;                                                                     \
        return no_variables_of_type(c, nvr);                                                       \
    }

ABSENT(Integer)
ABSENT(String)

/* States */

static struct instance *instance_or_null(fmi2Component c)
{
    return c ? instance_of(c) : NULL;
}

FMI2_Export fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    return (fmi2Status)state_get(instance_or_null(c), FMUstate);
}

FMI2_Export fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    return (fmi2Status)state_set(instance_or_null(c), FMUstate);
}

FMI2_Export fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    (void)c;
    return (fmi2Status)state_free(FMUstate);
}

FMI2_Export fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate,
                                                  size_t *size)
{
    return (fmi2Status)state_size(instance_or_null(c), FMUstate, size);
}

FMI2_Export fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate,
                                             fmi2Byte serializedState[], size_t size)
{
    return (fmi2Status)state_serialize(instance_or_null(c), FMUstate, serializedState, size);
}

FMI2_Export fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[],
                                               size_t size, fmi2FMUstate *FMUstate)
{
    return (fmi2Status)state_deserialize(instance_or_null(c), serializedState, size, FMUstate);
}

FMI2_Export fmi2Status fmi2GetDirectionalDerivative(fmi2Component c,
                                                    const fmi2ValueReference vUnknown_ref[],
                                                    size_t nUnknown,
                                                    const fmi2ValueReference vKnown_ref[],
                                                    size_t nKnown, const fmi2Real dvKnown[],
                                                    fmi2Real dvUnknown[])
{
    if (!c)
        return fmi2Error;
    if ((nUnknown && (!vUnknown_ref || !dvUnknown)) || (nKnown && (!vKnown_ref || !dvKnown)))
        return reject(c, STATUS_ERROR, "getDirectionalDerivative: null pointer");
    struct derivative_call call = {vUnknown_ref, nUnknown, vKnown_ref, nKnown,
                                   dvKnown,      nKnown,   dvUnknown,  nUnknown};
    return (fmi2Status)get_directional_derivative(instance_of(c), &call);
}

/* Co-simulation */

FMI2_Export fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[],
                                                   size_t nvr, const fmi2Integer order[],
                                                   const fmi2Real value[])
{
    (void)vr, (void)nvr, (void)order, (void)value;
    return reject(c, STATUS_ERROR, "this FMU does not interpolate inputs");
}

FMI2_Export fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[],
                                                    size_t nvr, const fmi2Integer order[],
                                                    fmi2Real value[])
{
    (void)vr, (void)nvr, (void)order, (void)value;
    return reject(c, STATUS_ERROR, "this FMU has no output derivatives");
}

FMI2_Export fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint,
                                  fmi2Real communicationStepSize,
                                  fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!c)
        return fmi2Error;
    return (fmi2Status)instance_step(instance_of(c), currentCommunicationPoint,
                                     communicationStepSize, NULL);
}

FMI2_Export fmi2Status fmi2CancelStep(fmi2Component c)
{
    return reject(c, STATUS_ERROR, "cancelStep: no step is under way, steps are synchronous");
}

static fmi2Status no_such_status(fmi2Component c)
{
    return c ? reject(c, STATUS_DISCARD, "this FMU does not have this status") : fmi2Error;
}

#define ABSENT_STATUS(name, type)                                                                  \
    FMI2_Export fmi2Status name(fmi2Component c, const fmi2StatusKind s, type *value)              \
    {                                                                                              \
        (void)s, (void)value;                                                                      \
        return no_such_status(c);                                                                  \
    }

ABSENT_STATUS(fmi2GetStatus, fmi2Status)
ABSENT_STATUS(fmi2GetIntegerStatus, fmi2Integer)
ABSENT_STATUS(fmi2GetStringStatus, fmi2String)

FMI2_Export fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    if (!c || !value || s != fmi2LastSuccessfulTime)
        return no_such_status(c);
    *value = instance_of(c)->time;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s,
                                            fmi2Boolean *value)
{
    if (!c || !value || s != fmi2Terminated)
        return no_such_status(c);
    *value = fmi2False; /* no model ends the simulation by itself */
    return fmi2OK;
}
