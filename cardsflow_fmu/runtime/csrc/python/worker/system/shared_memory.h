/* Memory that two processes share. It has no name in the system: it is gone with them. */
#ifndef SHARED_MEMORY_H
#define SHARED_MEMORY_H

#include "../../../platform/text.h"

#include <stddef.h>

struct shared_memory {
    void *bytes; /* zeros at first */
    size_t size;
#ifdef _WIN32
    void *handle;
#else
    int handle;
#endif
};

/* 0, or nonzero with a message. */
int shared_memory_create(struct shared_memory *memory, size_t size, struct text *error);

/* Maps what another process made; `handle` and `size` are set. 0, or nonzero. */
int shared_memory_map(struct shared_memory *memory);

void shared_memory_close(struct shared_memory *memory);

#endif
