/* Clock and files of a computer with POSIX. On a microcontroller, replace this file. */
#ifndef PLATFORM_H
#define PLATFORM_H

#include <fcntl.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>
#include <unistd.h>

static const uint64_t SECOND = 1000000000; /* [ns] */

static uint64_t clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * SECOND + (uint64_t)t.tv_nsec;
}

/* Return the number of bytes that were read; 0 if the file cannot be read. */
static size_t read_file(const char *name, void *to, size_t size)
{
    const int file = open(name, O_RDONLY);
    const ssize_t got = read(file, to, size);
    close(file);
    return got < 0 ? 0 : (size_t)got;
}

#endif
