/* The body as an FMI 2.0 co-simulation FMU with scalars; the rest is written by external_fmus.py. */
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#include "body.h"

/* Value references: pulls 0..3, angles 4..5, rates 6..7, inertia 8; the brake, a Boolean, 9. */
static double *real(body *b, fmi2ValueReference r)
{
    if (r < 4) {
        return &b->pulls[r];
    }
    if (r < 6) {
        return &b->angles[r - 4];
    }
    return r < 8 ? &b->rates[r - 6] : r == 8 ? &b->inertia : NULL;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    (void)name, (void)resources, (void)functions, (void)visible, (void)logging;
    body *b = type == fmi2CoSimulation && strcmp(guid, "{body}") == 0 ? malloc(sizeof *b) : NULL;
    if (b) {
        body_start(b);
    }
    return b;
}

void fmi2FreeInstance(fmi2Component c)
{
    free(c);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    return ((body *)c)->inertia > 0.0 ? fmi2OK : fmi2Error;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    body_start(c);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[])
{
    for (size_t k = 0; k < n; k++) {
        const double *value = real(c, vr[k]);
        if (!value) {
            return fmi2Error;
        }
        values[k] = *value;
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                       const fmi2Real values[])
{
    for (size_t k = 0; k < n; k++) {
        double *value = real(c, vr[k]);
        if (!value) {
            return fmi2Error;
        }
        *value = values[k];
    }
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                          const fmi2Boolean values[])
{
    for (size_t k = 0; k < n; k++) {
        if (vr[k] != 9) {
            return fmi2Error;
        }
        ((body *)c)->brake = values[k];
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_way_back)
{
    (void)no_way_back;
    body_step(c, h);
    return is_stuck(c, t) ? fmi2Error : fmi2OK;
}
