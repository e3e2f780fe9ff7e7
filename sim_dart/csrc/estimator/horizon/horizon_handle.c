/* Memory and arrays of a horizon. */
#include "frames.h"

#include <string.h>

#define HORIZON_LENGTHS(c, imus, frames)                                                               \
    const size_t n = (size_t)(c)->blob.counts.dofs, m = (size_t)(c)->blob.counts.muscles;              \
    const size_t bends = (size_t)(c)->blob.counts.bends, i = (size_t)(imus), K = (size_t)(frames);     \
    const size_t N = 3 * n + 6 * i, B = 2 * m + 2 * n + 6 * i, T = m + 3 * n + 6 * i;

enum { MIN_FRAMES = 2, MAX_FRAMES = 1000 };
static const size_t HANDLE_SIZE = (sizeof(horizon) + 7u) / 8u * 8u;

size_t estimator_horizon_size(const core *c, int32_t imus, int32_t frames)
{
    if (imus < 0 || imus > MAX_IMUS || frames < MIN_FRAMES || frames > MAX_FRAMES) return 0;
    HORIZON_LENGTHS(c, imus, frames)
    size_t reals = N * N + N + B;
#define ADD_LENGTH(name, length) reals += length;
#define ADD_LENGTHS(name, length) reals += K * (length);
    HORIZON_SETTINGS(ADD_LENGTH)
    HORIZON_REMEMBERED(ADD_LENGTH)
    HORIZON_FRAMES(ADD_LENGTHS)
    HORIZON_WORK(ADD_LENGTHS)
#undef ADD_LENGTH
#undef ADD_LENGTHS
    return HANDLE_SIZE + reals * sizeof(real);
}

int estimator_use_horizon(estimator *e, int32_t frames, void *memory)
{
    e->horizon = NULL;
    const size_t size = estimator_horizon_size(e->core, (int32_t)e->i, frames);
    if (!size || !memory || (uintptr_t)memory % 8) return 1;
    memset(memory, 0, size);
    HORIZON_LENGTHS(e->core, e->i, frames)
    horizon *h = e->horizon = memory;
    h->K = K, h->B = B, h->T = T;
    real *at = (real *)(void *)((char *)memory + HANDLE_SIZE);
#define PLACE(name, length) h->name = at, at += length;
#define PLACES(name_, length) h->name_ = at, h->name_##_length = length, at += K * (length);
    HORIZON_SETTINGS(PLACE)
    HORIZON_REMEMBERED(PLACE)
    HORIZON_FRAMES(PLACES)
    h->remembered = (size_t)(at - h->frames);
    HORIZON_WORK(PLACES)
#undef PLACE
#undef PLACES
    h->P = at, h->mean = at + N * N, h->given = h->mean + N;
    for (size_t j = 0; j < n; j++) h->low[j] = -INFINITY, h->high[j] = INFINITY;
    return 0;
}

real *horizon_array(estimator *e, const char *name, size_t *length)
{
    horizon *h = e->horizon;
    if (!h) return NULL;
    HORIZON_LENGTHS(e->core, e->i, h->K)
    (void)m, (void)bends, (void)B, (void)T;
#define FIND(name_, length_) \
    if (!strcmp(name, #name_)) return *length = length_, h->name_;
    HORIZON_SETTINGS(FIND)
    FIND(iterations, 1)
    FIND(x, K * N)
#undef FIND
    return strcmp(name, "remembered_frames") ? NULL : (*length = h->remembered, h->frames);
}
