#ifndef _WIN32

#include "shared_memory.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#ifdef __linux__
#include <sys/syscall.h>

/* Call the system directly: older C libraries have no function for it. */
static int create_file(void)
{
    const unsigned close_on_exec = 1;
    return (int)syscall(SYS_memfd_create, "cardsflow", close_on_exec);
}
#else
/* Create a file with a name that exists only until it is open. */
static int create_file(void)
{
    enum { TRIES = 1000 };
    char name[32];
    for (int i = 0; i < TRIES; i++) {
        snprintf(name, sizeof name, "/cardsflow.%ld.%d", (long)getpid(), i);
        int file = shm_open(name, O_RDWR | O_CREAT | O_EXCL, 0600);
        if (file >= 0)
            shm_unlink(name);
        if (file >= 0 || errno != EEXIST)
            return file;
    }
    return -1;
}
#endif

int shared_memory_map(struct shared_memory *memory)
{
    void *bytes =
        mmap(NULL, memory->size, PROT_READ | PROT_WRITE, MAP_SHARED, memory->handle, 0);
    memory->bytes = bytes == MAP_FAILED ? NULL : bytes;
    return memory->bytes == NULL;
}

int shared_memory_create(struct shared_memory *memory, size_t size, struct text *error)
{
    memory->bytes = NULL;
    memory->size = size;
    memory->handle = create_file();
    if (memory->handle >= 0 && ftruncate(memory->handle, (off_t)size) == 0 &&
        shared_memory_map(memory) == 0)
        return 0;
    text_set(error, "no shared memory of %lu bytes: %s", (unsigned long)size,
             strerror(errno));
    shared_memory_close(memory);
    return 1;
}

void shared_memory_close(struct shared_memory *memory)
{
    if (memory->bytes)
        munmap(memory->bytes, memory->size);
    if (memory->handle >= 0)
        close(memory->handle);
    memory->bytes = NULL;
    memory->handle = -1;
}

#endif
