/* The handle of a monitor: its memory and its arrays. */
#include "state.h"

#include <string.h>

enum { MAX_COORDINATES = 256, MAX_MUSCLES = 1024 };

#define FAULTS_SIZES(coordinates, muscles)                                                             \
    const size_t n = (size_t)(coordinates), m = (size_t)(muscles), c = 2 * m + n, p = m + c;

size_t faults_size(int coordinates, int muscles)
{
    if (coordinates < 1 || coordinates > MAX_COORDINATES || muscles < 1 || muscles > MAX_MUSCLES) return 0;
    FAULTS_SIZES(coordinates, muscles)
    size_t count = 0;
    FAULTS_ARRAYS(NAMED_LENGTH)
    return padded(sizeof(faults)) + count * sizeof(real);
}

faults *faults_open(int coordinates, int muscles, void *memory)
{
    const size_t size = faults_size(coordinates, muscles);
    if (!size || !memory || (uintptr_t)memory % 8) return NULL;
    memset(memory, 0, size);
    FAULTS_SIZES(coordinates, muscles)
    faults *s = memory;
    s->n = n, s->m = m, s->c = c, s->p = p;
    real *at = (real *)(void *)((char *)memory + padded(sizeof *s));
    FAULTS_ARRAYS(NAMED_PLACE)
    return s;
}

static size_t remembered(const faults *s)
{
    return (size_t)(s->count + ONSETS - s->clock);
}

real *faults_array(faults *s, const char *name, size_t *length)
{
    const size_t n = s->n, m = s->m, p = s->p;
    if (!strcmp(name, "remembered")) return *length = remembered(s), s->clock;
    FAULTS_NAMED(NAMED_FIND)
    return NULL;
}

void faults_reset(faults *s)
{
    memset(s->clock, 0, remembered(s) * sizeof(real));
    for (size_t i = 0; i < s->c; i++) s->suspicion[i] = -1;
    faults_forget_motion(s);
    s->step = 0;
    for (size_t i = 0; i < s->p; i++) s->usable[i] = 1, s->other[i] = -1;
    memcpy(s->bound, s->f_max, s->m * sizeof(real));
}
