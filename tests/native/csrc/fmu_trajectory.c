/* A host in C, without Python: steps an FMI 2.0 FMU with synthetic inputs, and prints its outputs bit for
   bit.

   Arguments: library, GUID, resource location, number of steps, step in ms, number of inputs, then value
   references of the inputs and of the outputs. Every input oscillates about its start value. */
#ifdef _WIN32
#include <windows.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)library, name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

enum { MAX_MEMORY = 400 };

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

static void *function(void *library, const char *name)
{
    void *found = FIND(library, name);
    if (!found) {
        fprintf(stderr, "no %s\n", name);
        exit(2);
    }
    return found;
}

static void print(const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, values + i, sizeof bits);
        printf("%08lx%08lx%c", (unsigned long)(bits >> 32), (unsigned long)(bits & 0xffffffffu),
               i + 1 < count ? ' ' : '\n');
    }
}

int main(int count, char **arguments)
{
    const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    fmi2ValueReference references[MAX_MEMORY];
    fmi2Real start[MAX_MEMORY], values[MAX_MEMORY];
    void *library = count > 7 && count < MAX_MEMORY ? OPEN(arguments[1]) : NULL;
    if (!library) {
        fprintf(stderr, "no library\n");
        return 2;
    }
#define LOAD(name) name##TYPE *name = (name##TYPE *)function(library, #name)
    LOAD(fmi2Instantiate);
    LOAD(fmi2SetupExperiment);
    LOAD(fmi2EnterInitializationMode);
    LOAD(fmi2ExitInitializationMode);
    LOAD(fmi2SetReal);
    LOAD(fmi2GetReal);
    LOAD(fmi2DoStep);
    LOAD(fmi2FreeInstance);
    const int steps = atoi(arguments[4]);
    const double step = atoi(arguments[5]) / 1000.0;
    const size_t all = (size_t)(count - 7), inputs = (size_t)atoi(arguments[6]), outputs = all - inputs;
    for (size_t i = 0; i < all; i++) references[i] = (fmi2ValueReference)atoi(arguments[7 + i]);
    fmi2Component c = fmi2Instantiate("host", fmi2CoSimulation, arguments[2], arguments[3], &callbacks,
                                      fmi2False, fmi2False);
    if (!c || fmi2SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0) != fmi2OK ||
        fmi2EnterInitializationMode(c) != fmi2OK || fmi2ExitInitializationMode(c) != fmi2OK ||
        fmi2GetReal(c, references, inputs, start) != fmi2OK)
        return 1;
    for (int k = 0; k < steps; k++) {
        for (size_t i = 0; i < inputs; i++)
            values[i] = start[i] + 0.1 * ((double)((k + 7 * (int)i) % 23) / 23.0);
        if (fmi2SetReal(c, references, inputs, values) != fmi2OK ||
            fmi2DoStep(c, k * step, step, fmi2True) != fmi2OK ||
            fmi2GetReal(c, references + inputs, outputs, values) != fmi2OK)
            return 1;
        print(values, outputs);
    }
    fmi2FreeInstance(c);
    return 0;
}
