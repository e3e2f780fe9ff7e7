/* The complete state of an instance at one time. */
#ifndef SAVED_STATE_H
#define SAVED_STATE_H

#include "instance.h"

#include <stddef.h>

/* A block of `size` bytes: a header, the values, then the bytes of the model. This is also the serialized
 * form, in the byte order of the machine. */
struct saved_state {
    size_t size;
    unsigned char bytes[];
};

/* Store the current state in a new block on the heap. */
enum status saved_state_take(struct instance *instance, struct saved_state **saved);

/* Restore a state of this instance or of another instance of the same FMU. */
enum status saved_state_restore(struct instance *instance, const struct saved_state *saved);

/* Copy serialized bytes to the heap; reject bytes that are not a state of this FMU. */
enum status saved_state_read(struct instance *instance, const void *bytes, size_t size,
                             struct saved_state **saved);

#endif
