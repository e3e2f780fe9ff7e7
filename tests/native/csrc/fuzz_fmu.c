/* libFuzzer inputs as data from hosts of an FMU: saved states, and the table of variables.

   FUZZ_RESOURCES are the resources of a valid native FMU, FUZZ_SCRATCH is a folder for output. With
   FUZZ_SEED only a valid state is written to that folder. */
#include "cardsflow_fmu/runtime/csrc/model/port_table.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *variable(const char *name)
{
    const char *value = getenv(name);
    if (!value) exit(2);
    return value;
}

#if defined(FUZZ_PORTS)
enum { LENGTH_AT = 12, CHECKSUM_AT = 16, CHECKED_FROM = 20 };

static uint32_t checksum(const unsigned char *bytes, size_t size)
{
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int k = 0; k < 8; k++) crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1u)));
    }
    return ~crc;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct port_table ports;
    struct text error = {0};
    char path[4096];
    if (size < CHECKED_FROM) return 0;
    unsigned char *bytes = malloc(size);
    if (!bytes) return 0;
    memcpy(bytes, data, size);
    const uint32_t length = (uint32_t)size, sum = checksum(bytes + CHECKED_FROM, size - CHECKED_FROM);
    memcpy(bytes + LENGTH_AT, &length, 4), memcpy(bytes + CHECKSUM_AT, &sum, 4);
    snprintf(path, sizeof path, "%s/ports.bin", variable("FUZZ_SCRATCH"));
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, size, file) != size || fclose(file)) exit(2);
    free(bytes);
    if (!port_table_read(&ports, variable("FUZZ_SCRATCH"), &error)) {
        for (size_t i = 0; i < ports.count; i++)
            if (ports.ports[i].size && !strlen(ports.ports[i].name)) exit(3);
        port_table_free(&ports);
    } else if (!*text_get(&error))
        exit(4); /* failed without a message */
    text_free(&error);
    return 0;
}
#else
#include "cardsflow_fmu/runtime/csrc/fmi/fmi2.c"

static void log_nothing(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...)
{
    (void)e, (void)n, (void)s, (void)c, (void)m;
}

static fmi2Component made(void)
{
    static const fmi2CallbackFunctions functions = {log_nothing, calloc, free, NULL, NULL};
    struct port_table ports;
    struct text error = {0};
    char uri[4096];
    if (port_table_read(&ports, variable("FUZZ_RESOURCES"), &error)) exit(2);
    snprintf(uri, sizeof uri, "file://%s", variable("FUZZ_RESOURCES"));
    fmi2Component c = fmi2Instantiate("it", fmi2CoSimulation, ports.guid, uri, &functions, 0, 0);
    port_table_free(&ports);
    if (!c || fmi2SetupExperiment(c, 0, 0, 0, 0, 0) || fmi2EnterInitializationMode(c) ||
        fmi2ExitInitializationMode(c))
        exit(5);
    return c;
}

int LLVMFuzzerInitialize(int *count, char ***words)
{
    (void)count, (void)words;
    const char *seed = getenv("FUZZ_SEED");
    if (!seed) return 0;
    fmi2Component c = made();
    fmi2FMUstate state = NULL;
    size_t size = 0;
    if (fmi2GetFMUstate(c, &state) || fmi2SerializedFMUstateSize(c, state, &size)) exit(6);
    fmi2Byte *bytes = malloc(size);
    FILE *file = fopen(seed, "wb");
    if (!bytes || !file || fmi2SerializeFMUstate(c, state, bytes, size)) exit(7);
    if (fwrite(bytes, 1, size, file) != size || fclose(file)) exit(8);
    _Exit(0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static fmi2Component c;
    fmi2FMUstate state = NULL;
    if (!c) c = made();
    fmi2Byte *bytes = malloc(size + !size);
    if (!bytes) return 0;
    memcpy(bytes, data, size);
    if (!fmi2DeSerializeFMUstate(c, bytes, size, &state) && !fmi2SetFMUstate(c, state)) {
        size_t again = 0;
        fmi2SerializedFMUstateSize(c, state, &again);
        for (int k = 0; k < 3; k++)
            if (fmi2DoStep(c, 1e-3 * k, 1e-3, 1)) break;
    }
    if (state) fmi2FreeFMUstate(c, &state);
    free(bytes);
    fmi2FreeInstance(c), c = NULL; /* a failed FMU cannot continue */
    return 0;
}
#endif
