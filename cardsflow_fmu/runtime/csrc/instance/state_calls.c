#include "state_calls.h"

#include "saved_state.h"

#include <stdlib.h>
#include <string.h>

static enum status reject(struct instance *instance, const char *text)
{
    if (instance)
        log_status(&instance->log, STATUS_ERROR, text);
    return STATUS_ERROR;
}

enum status state_get(struct instance *instance, void **state)
{
    struct saved_state *saved = NULL;
    if (!instance || !state)
        return reject(instance, "getFMUstate: null pointer");
    enum status status = saved_state_take(instance, &saved);
    if (status != STATUS_OK)
        return status;
    free(*state);
    *state = saved;
    return STATUS_OK;
}

enum status state_set(struct instance *instance, const void *state)
{
    if (!instance || !state)
        return reject(instance, "setFMUstate: null pointer");
    return saved_state_restore(instance, state);
}

enum status state_free(void **state)
{
    if (state) {
        free(*state);
        *state = NULL;
    }
    return STATUS_OK;
}

enum status state_size(struct instance *instance, const void *state, size_t *size)
{
    if (!state || !size)
        return reject(instance, "serializedFMUstateSize: null pointer");
    *size = ((const struct saved_state *)state)->size;
    return STATUS_OK;
}

enum status state_serialize(struct instance *instance, const void *state, void *bytes, size_t size)
{
    const struct saved_state *saved = state;
    if (!saved || !bytes)
        return reject(instance, "serializeFMUstate: null pointer");
    if (size < saved->size)
        return reject(instance, "serializeFMUstate: the buffer is too small");
    memcpy(bytes, saved->bytes, saved->size);
    return STATUS_OK;
}

enum status state_deserialize(struct instance *instance, const void *bytes, size_t size,
                              void **state)
{
    struct saved_state *saved = NULL;
    if (!instance || !state)
        return reject(instance, "deSerializeFMUstate: null pointer");
    enum status status = saved_state_read(instance, bytes, size, &saved);
    if (status != STATUS_OK)
        return status;
    free(*state);
    *state = saved;
    return STATUS_OK;
}
