/* Memory that two processes share. It has no name in the system and is released with both processes. */
#ifndef SHARED_MEMORY_H
#define SHARED_MEMORY_H

#include "../../../platform/text.h"

#include <stddef.h>

struct shared_memory {
    void *bytes; /* initially zeros */
    size_t size;
#ifdef _WIN32
    void *handle;
#else
    int handle;
#endif
};

/* Return 0, or nonzero with a message. */
int shared_memory_create(struct shared_memory *memory, size_t size, struct text *error);

/* Map the memory of another process; `handle` and `size` must be set. Return 0, or nonzero. */
int shared_memory_map(struct shared_memory *memory);

void shared_memory_close(struct shared_memory *memory);

#endif
