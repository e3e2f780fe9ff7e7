#include "saved_state.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { FORMAT_VERSION = 1 };

static const char MAGIC[8] = {'C', 'A', 'R', 'D', 'S', 'F', 'S', 'T'};

struct header {
    char magic[8];
    uint32_t version;
    uint32_t life_cycle;
    uint32_t is_set_up;
    uint32_t initialization_is_due;
    uint64_t size;     /* size of the whole block, in bytes */
    uint64_t guid;     /* hash of the GUID: a state belongs to one FMU */
    uint64_t count;    /* number of values */
    double start_time, stop_time, time;
};

/* FNV-1a. */
static uint64_t hash(const char *text)
{
    uint64_t value = 0xcbf29ce484222325u;
    for (; *text; text++)
        value = (value ^ (unsigned char)*text) * 0x100000001b3u;
    return value;
}

static size_t values_size(const struct instance *instance)
{
    return instance->ports.count * sizeof(double);
}

/* Get the state of the model. Before initialization it consists of the values only. */
static int take_model_state(struct instance *instance, void **bytes, size_t *size)
{
    if (instance->initialization_is_due)
        return 0;
    return instance->model.functions->get_state(&instance->model, bytes, size);
}

static struct header describe(const struct instance *instance, size_t size)
{
    struct header header;
    memset(&header, 0, sizeof header);
    memcpy(header.magic, MAGIC, sizeof MAGIC);
    header.version = FORMAT_VERSION;
    header.life_cycle = (uint32_t)instance->life_cycle;
    header.is_set_up = (uint32_t)instance->is_set_up;
    header.initialization_is_due = (uint32_t)instance->initialization_is_due;
    header.size = size;
    header.guid = hash(instance->ports.guid);
    header.count = instance->ports.count;
    header.start_time = instance->start_time;
    header.stop_time = instance->stop_time;
    header.time = instance->time;
    return header;
}

static struct saved_state *assemble(const struct instance *instance, const void *model_bytes,
                                    size_t model_size)
{
    size_t size = sizeof(struct header) + values_size(instance) + model_size;
    struct saved_state *saved = malloc(sizeof *saved + size);
    if (!saved)
        return NULL;
    struct header header = describe(instance, size);
    unsigned char *at = saved->bytes;
    saved->size = size;
    memcpy(at, &header, sizeof header);
    at += sizeof header;
    memcpy(at, instance->model.values, values_size(instance));
    at += values_size(instance);
    if (model_size)
        memcpy(at, model_bytes, model_size);
    return saved;
}

enum status saved_state_take(struct instance *instance, struct saved_state **saved)
{
    void *bytes = NULL;
    size_t size = 0;
    if (!instance_allows(instance, "getFMUstate", ~(unsigned)FAILED))
        return STATUS_ERROR;
    if (take_model_state(instance, &bytes, &size))
        return instance_fail(instance, "getFMUstate: %s", text_get(&instance->model.error));
    *saved = assemble(instance, bytes, size);
    free(bytes);
    return *saved ? STATUS_OK : instance_fail(instance, "getFMUstate: out of memory");
}

static int is_consistent(const struct header *header)
{
    if (!isfinite(header->start_time) || !isfinite(header->time) ||
        !(header->stop_time >= header->start_time))
        return 0;
    switch (header->life_cycle) {
    case INSTANTIATED:
        return header->initialization_is_due == 1;
    case INITIALIZATION_MODE:
        return header->initialization_is_due <= 1;
    case STEP_MODE:
    case EVENT_MODE:
    case CONTINUOUS_MODE:
    case TERMINATED:
        return header->initialization_is_due == 0;
    default:
        return 0;
    }
}

/* Return whether inputs and parameters are finite. */
static int are_finite(const struct instance *instance, const unsigned char *values)
{
    for (size_t i = 0; i < instance->ports.count; i++) {
        double value;
        memcpy(&value, values + i * sizeof value, sizeof value);
        if (instance->ports.ports[i].causality != CAUSALITY_OUTPUT && !isfinite(value))
            return 0;
    }
    return 1;
}

/* Return the error in serialized bytes, or NULL. */
static const char *check(const struct instance *instance, const void *bytes, size_t size)
{
    struct header header;
    size_t fixed = sizeof header + values_size(instance);
    if (size < fixed)
        return "is too short";
    memcpy(&header, bytes, sizeof header);
    if (memcmp(header.magic, MAGIC, sizeof MAGIC) != 0 || header.version != FORMAT_VERSION)
        return "is not a state of this version";
    if (header.size != size)
        return "has another length than it had when it was serialized";
    if (header.guid != hash(instance->ports.guid) || header.count != instance->ports.count)
        return "belongs to another FMU";
    if (!is_consistent(&header) ||
        !are_finite(instance, (const unsigned char *)bytes + sizeof header))
        return "is damaged";
    return NULL;
}

enum status saved_state_read(struct instance *instance, const void *bytes, size_t size,
                             struct saved_state **saved)
{
    struct text error = {NULL};
    const char *wrong = bytes ? check(instance, bytes, size) : "is missing";
    struct saved_state *copy = wrong ? NULL : malloc(sizeof *copy + size);
    if (!copy) {
        text_set(&error, "deSerializeFMUstate: the state %s", wrong ? wrong : "needs more memory");
        log_status(&instance->log, STATUS_ERROR, text_get(&error));
        text_free(&error);
        return STATUS_ERROR;
    }
    copy->size = size;
    memcpy(copy->bytes, bytes, size);
    *saved = copy;
    return STATUS_OK;
}

static const unsigned char *saved_values(const struct saved_state *saved)
{
    return saved->bytes + sizeof(struct header);
}

static void restore_values(struct instance *instance, const struct saved_state *saved)
{
    memcpy(instance->model.values, saved_values(saved), values_size(instance));
}

/* Return whether a parameter differs from the value that the model uses. */
static int parameters_differ(const struct instance *instance, const struct saved_state *saved)
{
    for (size_t i = 0; i < instance->ports.count; i++)
        if (instance->ports.ports[i].causality == CAUSALITY_PARAMETER &&
            memcmp(saved_values(saved) + i * sizeof(double), &instance->model.values[i],
                   sizeof(double)) != 0)
            return 1;
    return 0;
}

static void restore_header(struct instance *instance, const struct header *header)
{
    instance->life_cycle = (enum life_cycle)header->life_cycle;
    instance->is_set_up = header->is_set_up != 0;
    instance->initialization_is_due = header->initialization_is_due != 0;
    instance->evaluation_is_due = 1;
    instance->start_time = header->start_time;
    instance->stop_time = header->stop_time;
    instance->time = header->time;
}

/* Restore the model. The values are copied first, for a model that computes from them, and again last, to be
   bit-identical. */
static enum status restore_model(struct instance *instance, const struct saved_state *saved)
{
    size_t fixed = sizeof(struct header) + values_size(instance);
    restore_values(instance, saved);
    if (instance->model.functions->set_state(&instance->model, saved->bytes + fixed,
                                             saved->size - fixed))
        return instance_fail(instance, "setFMUstate: %s", text_get(&instance->model.error));
    restore_values(instance, saved);
    return STATUS_OK;
}

static enum status reset_model(struct instance *instance, const struct saved_state *saved)
{
    if (instance->model.functions->reset(&instance->model))
        return instance_fail(instance, "setFMUstate: %s", text_get(&instance->model.error));
    restore_values(instance, saved);
    return STATUS_OK;
}

/* Initialize a model that uses other parameters than the state, so that it accepts the bytes. */
static enum status prepare_model(struct instance *instance, const struct saved_state *saved)
{
    if (reset_model(instance, saved) != STATUS_OK)
        return STATUS_ERROR;
    instance->initialization_is_due = 1;
    return instance_update(instance);
}

enum status saved_state_restore(struct instance *instance, const struct saved_state *saved)
{
    struct header header;
    const char *wrong = check(instance, saved->bytes, saved->size);
    if (wrong)
        return instance_fail(instance, "setFMUstate: the state %s", wrong);
    memcpy(&header, saved->bytes, sizeof header);
    int needs_preparation = instance->life_cycle == FAILED || instance->initialization_is_due ||
                     parameters_differ(instance, saved);
    restore_header(instance, &header);
    if (header.initialization_is_due)
        return reset_model(instance, saved);
    if (needs_preparation && prepare_model(instance, saved) != STATUS_OK)
        return STATUS_ERROR;
    return restore_model(instance, saved);
}
