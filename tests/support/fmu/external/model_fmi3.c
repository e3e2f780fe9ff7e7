/* A model as an FMI 3.0 co-simulation FMU with arrays; the rest is written by external_fmus.py. */
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

typedef fmi3Int32 model_integer;
typedef fmi3Boolean model_boolean;
#define FMI 3
#include MODEL

static int is_configuring; /* structural parameters can be set */

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
    const fmi3ValueReference required[], size_t n, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
    (void)required, (void)n, (void)environment, (void)log, (void)update;
    model *m = strcmp(token, TOKEN) == 0 ? malloc(sizeof *m) : NULL;
    if (m) {
        model_start(m);
    }
    return m;
}

void fmi3FreeInstance(fmi3Instance c)
{
    free(c);
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c)
{
    (void)c;
    is_configuring = 1;
    return fmi3OK;
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c)
{
    (void)c;
    is_configuring = 0;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    return model_initialise(c) ? fmi3Error : fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c)
{
    model_start(c);
    return fmi3OK;
}

#define ACCESS(GET, SET, TYPE)                                                                         \
    fmi3Status GET(fmi3Instance c, const fmi3ValueReference vr[], size_t n, TYPE values[], size_t room) \
    {                                                                                                  \
        for (size_t k = 0, size = 1; k < n; k++, values += size, room -= size) {                       \
            const TYPE *from = model_variable(c, vr[k], &size);                                        \
            if (!from || size > room) {                                                                \
                return fmi3Error;                                                                      \
            }                                                                                          \
            memcpy(values, from, size * sizeof *values);                                               \
        }                                                                                              \
        return room ? fmi3Error : fmi3OK;                                                              \
    }                                                                                                  \
    fmi3Status SET(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const TYPE values[],       \
                   size_t room)                                                                        \
    {                                                                                                  \
        for (size_t k = 0, size = 1; k < n; k++, values += size, room -= size) {                       \
            TYPE *to = model_variable(c, vr[k], &size);                                                \
            if (!to || size > room || (is_structural(vr[k]) && !is_configuring)) {                     \
                return fmi3Error;                                                                      \
            }                                                                                          \
            memcpy(to, values, size * sizeof *values);                                                 \
        }                                                                                              \
        return room ? fmi3Error : fmi3OK;                                                              \
    }

ACCESS(fmi3GetFloat64, fmi3SetFloat64, fmi3Float64)
ACCESS(fmi3GetFloat32, fmi3SetFloat32, fmi3Float32)
ACCESS(fmi3GetInt8, fmi3SetInt8, fmi3Int8)
ACCESS(fmi3GetUInt8, fmi3SetUInt8, fmi3UInt8)
ACCESS(fmi3GetInt16, fmi3SetInt16, fmi3Int16)
ACCESS(fmi3GetUInt16, fmi3SetUInt16, fmi3UInt16)
ACCESS(fmi3GetInt32, fmi3SetInt32, fmi3Int32)
ACCESS(fmi3GetUInt32, fmi3SetUInt32, fmi3UInt32)
ACCESS(fmi3GetInt64, fmi3SetInt64, fmi3Int64)
ACCESS(fmi3GetUInt64, fmi3SetUInt64, fmi3UInt64)
ACCESS(fmi3GetBoolean, fmi3SetBoolean, fmi3Boolean)

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_way_back,
                      fmi3Boolean *event, fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last)
{
    (void)no_way_back;
    model_step(c, h);
    *event = *early = false;
    *end = model_ends(c, t);
    *last = t + h;
    return model_fails(c, t) ? fmi3Error : fmi3OK;
}
