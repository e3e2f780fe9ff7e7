/* A host without Python: steps an FMI 2.0 FMU and prints its outputs.
 *
 * Arguments: library, GUID, resource location, number of steps, value reference of an input, then of
 * the outputs to print. The input is the number of the step divided by 1000. */
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h"

enum { MOST_OUTPUTS = 100 };

static void log_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                        fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)name;
    va_list arguments;
    va_start(arguments, message);
    fprintf(stderr, "%d %s: ", (int)status, category);
    vfprintf(stderr, message, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

#define LOAD(type, name) type *name = (type *)dlsym(library, #name)

int main(int count, char **arguments)
{
    const double step = 1e-3;
    fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    void *library = count > 5 ? dlopen(arguments[1], RTLD_NOW) : NULL;
    if (!library) {
        fprintf(stderr, "%s\n", count > 5 ? dlerror() : "too few arguments");
        return 2;
    }
    LOAD(fmi2InstantiateTYPE, fmi2Instantiate);
    LOAD(fmi2SetupExperimentTYPE, fmi2SetupExperiment);
    LOAD(fmi2EnterInitializationModeTYPE, fmi2EnterInitializationMode);
    LOAD(fmi2ExitInitializationModeTYPE, fmi2ExitInitializationMode);
    LOAD(fmi2SetRealTYPE, fmi2SetReal);
    LOAD(fmi2GetRealTYPE, fmi2GetReal);
    LOAD(fmi2DoStepTYPE, fmi2DoStep);
    LOAD(fmi2TerminateTYPE, fmi2Terminate);
    LOAD(fmi2FreeInstanceTYPE, fmi2FreeInstance);
    fmi2ValueReference input = (fmi2ValueReference)atoi(arguments[5]), outputs[MOST_OUTPUTS];
    fmi2Real values[MOST_OUTPUTS];
    size_t number = (size_t)(count - 6);
    for (size_t i = 0; i < number; i++)
        outputs[i] = (fmi2ValueReference)atoi(arguments[6 + i]);
    fmi2Component c = fmi2Instantiate("host", fmi2CoSimulation, arguments[2], arguments[3],
                                      &callbacks, fmi2False, fmi2False);
    if (!c || fmi2SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0) != fmi2OK ||
        fmi2EnterInitializationMode(c) != fmi2OK || fmi2ExitInitializationMode(c) != fmi2OK)
        return 1;
    for (int k = 0; k < atoi(arguments[4]); k++) {
        fmi2Real u = k / 1000.0;
        if (fmi2SetReal(c, &input, 1, &u) != fmi2OK ||
            fmi2DoStep(c, k * step, step, fmi2True) != fmi2OK ||
            fmi2GetReal(c, outputs, number, values) != fmi2OK)
            return 1;
        for (size_t i = 0; i < number; i++)
            printf("%.17g%c", values[i], i + 1 < number ? ' ' : '\n');
    }
    if (fmi2Terminate(c) != fmi2OK)
        return 1;
    fmi2FreeInstance(c);
    return 0;
}
