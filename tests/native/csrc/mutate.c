#include "mutate.h"
#include "sim_dart/csrc/numbers/real.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

unsigned char *file_contents(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    if (!file || fseek(file, 0, SEEK_END)) exit(2);
    *size = (size_t)ftell(file);
    rewind(file);
    unsigned char *contents = malloc(*size);
    if (!contents || fread(contents, 1, *size, file) != *size) exit(2);
    fclose(file);
    return contents;
}

uint64_t draw(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

/* Return a position for `width` aligned bytes, more often near the beginning, which contains the counts. */
static size_t place(uint64_t *state, size_t size, size_t safe, size_t width)
{
    size_t end = size - width + 1;
    if (draw(state) % 2 && end > safe + 160) end = safe + 160;
    const size_t at = safe + draw(state) % (end - safe);
    return at / width * width >= safe ? at / width * width : safe;
}

static void damage(uint64_t *state, unsigned char *copy, size_t size, size_t safe)
{
    const real huge = PRECISE(1e300, 1e37), tiny = PRECISE(1e-300, 1e-37);
    const real numbers[] = {NAN, INFINITY, -INFINITY, -1, 0, 1, huge, -huge, tiny, 1e9, 0.5, 65536};
    const int32_t integers[] = {-1, 0, 1, 2, 3, 7, 64, 4095, 65536, INT32_MAX, INT32_MIN, -2};
    const size_t which = draw(state) % 12;
    switch (draw(state) % 3) {
    case 0: copy[place(state, size, safe, 1)] = (unsigned char)draw(state); break;
    case 1: memcpy(copy + place(state, size, safe, 4), integers + which, 4); break;
    default: memcpy(copy + place(state, size, safe, sizeof(real)), numbers + which, sizeof(real));
    }
}

unsigned char *mutated(uint64_t *state, const unsigned char *contents, size_t *size, size_t safe)
{
    size_t kept = *size;
    if (draw(state) % 16 == 0) kept = draw(state) % (*size + 64);
    unsigned char *copy = malloc(kept + !kept);
    if (!copy) exit(2);
    memset(copy, 0, kept);
    memcpy(copy, contents, kept < *size ? kept : *size);
    *size = kept;
    for (uint64_t times = 1 + draw(state) % 4; times-- && kept >= safe + 16;) damage(state, copy, kept, safe);
    return copy;
}
