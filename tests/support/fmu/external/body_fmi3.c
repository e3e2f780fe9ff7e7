/* The body as an FMI 3.0 co-simulation FMU with arrays; the rest is written by external_fmus.py. */
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

#include "body.h"

/* Value references: pulls[4] 1, angles[2] 2, rates[2] 3, inertia 4; the brake, a Boolean, 5. */
static double *array(body *b, fmi3ValueReference r, size_t *size)
{
    *size = r == 1 ? CABLES : r == 4 ? 1 : JOINTS;
    return r == 1 ? b->pulls : r == 2 ? b->angles : r == 3 ? b->rates : r == 4 ? &b->inertia : NULL;
}

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
    const fmi3ValueReference required[], size_t n, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
    (void)required, (void)n, (void)environment, (void)log, (void)update;
    body *b = strcmp(token, "{body}") == 0 ? malloc(sizeof *b) : NULL;
    if (b) {
        body_start(b);
    }
    return b;
}

void fmi3FreeInstance(fmi3Instance c)
{
    free(c);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    return ((body *)c)->inertia > 0.0 ? fmi3OK : fmi3Error;
}

fmi3Status fmi3Reset(fmi3Instance c)
{
    body_start(c);
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                          fmi3Float64 values[], size_t room)
{
    for (size_t k = 0, size; k < n; k++, values += size, room -= size) {
        const double *from = array(c, vr[k], &size);
        if (!from || size > room) {
            return fmi3Error;
        }
        memcpy(values, from, size * sizeof *values);
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                          const fmi3Float64 values[], size_t room)
{
    for (size_t k = 0, size; k < n; k++, values += size, room -= size) {
        double *to = array(c, vr[k], &size);
        if (!to || size > room) {
            return fmi3Error;
        }
        memcpy(to, values, size * sizeof *values);
    }
    return fmi3OK;
}

fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                          const fmi3Boolean values[], size_t room)
{
    if (n != 1 || room != 1 || vr[0] != 5) {
        return fmi3Error;
    }
    ((body *)c)->brake = values[0];
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_way_back,
                      fmi3Boolean *event, fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last)
{
    (void)no_way_back;
    body_step(c, h);
    *event = *early = false;
    *end = ends(c, t);
    *last = t + h;
    return is_stuck(c, t) ? fmi3Error : fmi3OK;
}
