/* The replay on a machine with a C library: replay_hosted FILE */
#include "replay_vectors.h"

#include <stdio.h>
#include <stdlib.h>

void say(const char *text)
{
    fputs(text, stdout);
}

void fail(const char *what, const char *name)
{
    fprintf(stderr, "%s: %s\n", name, what);
    exit(2);
}

void *allocate(size_t size)
{
    void *memory = size ? malloc(size) : NULL;
    if (!memory) fail("memory or size is rejected", "allocate");
    return memory;
}

static char *contents(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    if (!file) fail("cannot be read", path);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    char *bytes = allocate(*size);
    if (fread(bytes, 1, *size, file) != *size) fail("cannot be read", path);
    fclose(file);
    return bytes;
}

int main(int argc, char **argv)
{
    size_t size;
    if (argc != 2) fail("requires a file", argv[0]);
    const char *bytes = contents(argv[1], &size);
    return replay_vectors(bytes, size);
}
