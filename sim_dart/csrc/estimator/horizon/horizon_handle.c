/* Memory and arrays of a horizon. */
#include "frames.h"

#include <string.h>

#define HORIZON_LENGTHS(c, imus, offsets, frames)                                                              \
    const size_t n = (size_t)(c)->blob.counts.dofs, m = (size_t)(c)->blob.counts.muscles;              \
    const size_t bends = (size_t)(c)->blob.counts.bends, i = (size_t)(imus), K = (size_t)(frames);     \
    const size_t N = 3 * n + 6 * i + (size_t)(offsets), B = 2 * m + 2 * n + 6 * i, T = m + 3 * n + 6 * i;

enum { MIN_FRAMES = 2, MAX_FRAMES = 1000 };

size_t estimator_horizon_size(const core *c, int32_t imus, int32_t offsets, int32_t frames)
{
    if (!estimator_can_have(c, imus, offsets) || frames < MIN_FRAMES || frames > MAX_FRAMES) return 0;
    HORIZON_LENGTHS(c, imus, offsets, frames)
    size_t count = N * N + N + B;
#define ADD_LENGTHS(name, length) count += K * (length);
    HORIZON_SETTINGS(NAMED_LENGTH)
    HORIZON_REMEMBERED(NAMED_LENGTH)
    HORIZON_FRAMES(ADD_LENGTHS)
    HORIZON_WORK(ADD_LENGTHS)
#undef ADD_LENGTHS
    return padded(sizeof(horizon)) + count * sizeof(real);
}

int estimator_use_horizon(estimator *e, int32_t frames, void *memory)
{
    e->horizon = NULL;
    const size_t size = estimator_horizon_size(e->core, (int32_t)e->i, (int32_t)e->o, frames);
    if (!size || !memory || (uintptr_t)memory % 8) return 1;
    memset(memory, 0, size);
    HORIZON_LENGTHS(e->core, e->i, e->o, frames)
    horizon *s = e->horizon = memory;
    s->K = K, s->B = B, s->T = T;
    real *at = (real *)(void *)((char *)memory + padded(sizeof *s));
#define PLACES(name_, length) s->name_ = at, s->name_##_length = length, at += K * (length);
    HORIZON_SETTINGS(NAMED_PLACE)
    HORIZON_REMEMBERED(NAMED_PLACE)
    HORIZON_FRAMES(PLACES)
    s->remembered = (size_t)(at - s->frames);
    HORIZON_WORK(PLACES)
#undef PLACES
    s->P = at, s->mean = at + N * N, s->current = s->mean + N;
    for (size_t j = 0; j < n; j++) s->low[j] = -INFINITY, s->high[j] = INFINITY;
    return 0;
}

real *horizon_array(estimator *e, const char *name, size_t *length)
{
    horizon *s = e->horizon;
    if (!s) return NULL;
    HORIZON_LENGTHS(e->core, e->i, e->o, s->K)
    (void)m, (void)bends, (void)B, (void)T;
    HORIZON_SETTINGS(NAMED_FIND)
    NAMED_FIND(iterations, 1)
    NAMED_FIND(x, K * N)
    return strcmp(name, "remembered_frames") ? NULL : (*length = s->remembered, s->frames);
}
