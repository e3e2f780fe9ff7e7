/* A model as an FMI 2.0 co-simulation FMU; the rest is written by external_fmus.py. */
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

typedef fmi2Integer model_integer;
typedef fmi2Boolean model_boolean;
#define FMI 2
#include MODEL

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    (void)name, (void)resources, (void)functions, (void)visible, (void)logging;
    model *m = type == fmi2CoSimulation && strcmp(guid, TOKEN) == 0 ? malloc(sizeof *m) : NULL;
    if (m) {
        model_start(m);
    }
    return m;
}

void fmi2FreeInstance(fmi2Component c)
{
    free(c);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    return model_initialise(c) ? fmi2Error : fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    model_start(c);
    return fmi2OK;
}

#define ACCESS(GET, SET, TYPE)                                                                         \
    fmi2Status GET(fmi2Component c, const fmi2ValueReference vr[], size_t n, TYPE values[])            \
    {                                                                                                  \
        for (size_t k = 0, size; k < n; k++) {                                                         \
            const TYPE *value = model_variable(c, vr[k], &size);                                       \
            if (!value) {                                                                              \
                return fmi2Error;                                                                      \
            }                                                                                          \
            values[k] = *value;                                                                        \
        }                                                                                              \
        return fmi2OK;                                                                                 \
    }                                                                                                  \
    fmi2Status SET(fmi2Component c, const fmi2ValueReference vr[], size_t n, const TYPE values[])      \
    {                                                                                                  \
        for (size_t k = 0, size; k < n; k++) {                                                         \
            TYPE *value = model_variable(c, vr[k], &size);                                             \
            if (!value) {                                                                              \
                return fmi2Error;                                                                      \
            }                                                                                          \
            *value = values[k];                                                                        \
        }                                                                                              \
        return fmi2OK;                                                                                 \
    }

ACCESS(fmi2GetReal, fmi2SetReal, fmi2Real)
ACCESS(fmi2GetInteger, fmi2SetInteger, fmi2Integer)
ACCESS(fmi2GetBoolean, fmi2SetBoolean, fmi2Boolean)

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_way_back)
{
    (void)no_way_back;
    model_step(c, h);
    return model_fails(c, t) ? fmi2Error : fmi2OK;
}
