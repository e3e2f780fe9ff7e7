/* Opens damaged files of native FMUs: fuzz_native FIRST COUNT SCRATCH RESOURCES...

   SCRATCH is a folder for output; RESOURCES are the resources of valid FMUs. Each damaged native.bin is
   either rejected with a message, or is a model that can be stepped, saved and restored. Half of the files
   have a correct checksum. Prints the number of rejected files. */
#include "mutate.h"
#include "cardsflow_fmu/runtime/csrc/native/open.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { CHECKED_FROM = 20 };

static uint32_t checksum(const unsigned char *bytes, size_t size)
{
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int k = 0; k < 8; k++) crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1u)));
    }
    return ~crc;
}

/* Set the correct length and checksum. */
static void seal(unsigned char *bytes, size_t size)
{
    if (size < CHECKED_FROM) return;
    const uint32_t values[2] = {(uint32_t)size, checksum(bytes + CHECKED_FROM, size - CHECKED_FROM)};
    memcpy(bytes + 12, values, sizeof values);
}

static char *joined(const char *folder, const char *name)
{
    char *path = malloc(strlen(folder) + strlen(name) + 2);
    if (!path) exit(2);
    sprintf(path, "%s/%s", folder, name);
    return path;
}

static void write_file(const char *folder, const unsigned char *bytes, size_t size)
{
    char *path = joined(folder, "native.bin");
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, size, file) != size || fclose(file)) exit(2);
    free(path);
}

static void restore(struct model *model)
{
    void *bytes = NULL;
    size_t size = 0;
    if (!model->functions->get_state(model, &bytes, &size)) model->functions->set_state(model, bytes, size);
    free(bytes);
}

/* Return whether the time limit is exceeded: damaged settings may request a large number of steps. */
static int is_long(clock_t begin)
{
    return clock() - begin > CLOCKS_PER_SEC / 10;
}

/* Request the derivative of an output by a random value. */
static void ask(struct model *model, const struct port_table *ports, uint64_t *state)
{
    const double seed = 1;
    const uint32_t known = (uint32_t)(draw(state) % ports->count);
    const clock_t begin = clock();
    double answer;
    for (uint32_t i = 0; i < ports->count && model->functions->derivative && !is_long(begin); i++) {
        const struct derivative request = {1, &i, 1, &known, &seed, &answer};
        if (ports->ports[i].causality == CAUSALITY_OUTPUT && model->functions->derivative(model, &request))
            return;
    }
}

static void use(struct model *model, const struct port_table *ports, uint64_t *state)
{
    model->clock[0] = 0, model->clock[1] = 0.005;
    const clock_t begin = clock();
    if (model->functions->initialize(model)) return;
    for (int step = 0; step < 3; step++, model->clock[0] += 0.005) {
        for (size_t i = 0; i < ports->count; i++)
            if (ports->ports[i].causality == CAUSALITY_INPUT)
                model->values[i] += (double)(draw(state) >> 44) / 1e6 - 0.5;
        if (model->functions->step(model) || is_long(begin)) return;
        ask(model, ports, state);
        restore(model);
    }
}

/* Return whether the native.bin in `scratch`, with the variables in `resources`, is rejected; otherwise use
   it. */
static int is_rejected(const char *scratch, const char *resources, uint64_t *state)
{
    struct port_table ports;
    struct model model = {0};
    struct text error = {0};
    if (port_table_read(&ports, resources, &error)) exit(2);
    const int rejected = native_open(&model, &ports, scratch, &error);
    if (rejected && !*text_get(&error)) exit(3); /* rejected without a message */
    if (!rejected) {
        use(&model, &ports, state);
        model.functions->close(&model);
    }
    text_free(&model.error), text_free(&error), port_table_free(&ports);
    return rejected;
}

#if defined(CARDSFLOW_LIBFUZZER)
/* The first byte selects one of the numbered folders in FUZZ_RESOURCES. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *scratch = getenv("FUZZ_SCRATCH"), *all = getenv("FUZZ_RESOURCES");
    char resources[4096];
    uint64_t state = size;
    if (!scratch || !all) exit(2);
    if (size < 1 + CHECKED_FROM) return 0;
    snprintf(resources, sizeof resources, "%s/%d", all, data[0] % 8);
    unsigned char *bytes = malloc(size - 1);
    if (!bytes) return 0;
    memcpy(bytes, data + 1, size - 1);
    seal(bytes, size - 1);
    write_file(scratch, bytes, size - 1);
    is_rejected(scratch, resources, &state);
    free(bytes);
    return 0;
}
#else
static void damage(const char *scratch, const char *resources, uint64_t *state)
{
    size_t size;
    char *path = joined(resources, "native.bin");
    unsigned char *sound = file_contents(path, &size);
    const size_t safe = draw(state) % 2 ? CHECKED_FROM : 0;
    unsigned char *bytes = mutated(state, sound, &size, safe);
    if (safe) seal(bytes, size);
    write_file(scratch, bytes, size);
    free(bytes), free(sound), free(path);
}

int main(int argc, char **argv)
{
    unsigned long rejected = 0;
    if (argc < 5) return 2;
    const unsigned long first = strtoul(argv[1], NULL, 10), count = strtoul(argv[2], NULL, 10);
    for (unsigned long number = first; number < first + count; number++) {
        uint64_t state = number;
        const char *resources = argv[4 + draw(&state) % (uint64_t)(argc - 4)];
        damage(argv[3], resources, &state);
        rejected += (unsigned long)is_rejected(argv[3], resources, &state);
    }
    printf("%lu\n", rejected);
    return 0;
}
#endif
