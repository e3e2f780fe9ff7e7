/* The whole state of an instance at one moment, to go back to. */
#ifndef SAVED_STATE_H
#define SAVED_STATE_H

#include "instance.h"

#include <stddef.h>

/* A block of `size` bytes: a header, the values, then the model's own bytes. It is its own serialized
 * form, in the byte order of the machine. */
struct saved_state {
    size_t size;
    unsigned char bytes[];
};

/* The state now, on the heap, in `saved`. */
enum status saved_state_take(struct instance *instance, struct saved_state **saved);

/* Leads the instance to a state that was taken from it or from another instance of the same FMU. */
enum status saved_state_restore(struct instance *instance, const struct saved_state *saved);

/* A copy of serialized bytes, on the heap, in `saved`; rejects what is not a state of this FMU. */
enum status saved_state_read(struct instance *instance, const void *bytes, size_t size,
                             struct saved_state **saved);

#endif
