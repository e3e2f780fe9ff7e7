/* The estimator handle: its memory, its arrays, and the start. */
#include "horizon/frames.h"

#include <string.h>

#define ESTIMATOR_LENGTHS(c, imus, offsets)                                                            \
    const size_t n = (size_t)(c)->blob.counts.dofs, m = (size_t)(c)->blob.counts.muscles;              \
    const size_t variables = (size_t)(c)->blob.counts.variables, bends = (size_t)(c)->blob.counts.bends;       \
    const size_t i = (size_t)(imus), o = (size_t)(offsets), N = 3 * n + 6 * i + o;

size_t estimator_size(const core *c, int32_t imus, int32_t offsets)
{
    if (!estimator_can_have(c, imus, offsets)) return 0;
    ESTIMATOR_LENGTHS(c, imus, offsets)
    size_t count = 0;
    ESTIMATOR_ARRAYS(NAMED_LENGTH)
    return padded(sizeof(estimator)) + count * sizeof(real);
}

estimator *estimator_open(core *c, int32_t imus, const int32_t *imu_frame, int32_t offsets, void *memory)
{
    const size_t size = estimator_size(c, imus, offsets);
    if (!size || !memory || (uintptr_t)memory % 8) return NULL;
    for (int32_t k = 0; k < imus; k++)
        if (imu_frame[k] < 0 || imu_frame[k] >= c->blob.counts.frames) return NULL;
    memset(memory, 0, size);
    ESTIMATOR_LENGTHS(c, imus, offsets)
    estimator *s = memory;
    s->core = c, s->imu_frame = imu_frame;
    s->n = n, s->m = m, s->i = i, s->o = o, s->N = N, s->variables = variables, s->bends = bends;
    real *at = (real *)(void *)((char *)memory + padded(sizeof *s));
    ESTIMATOR_ARRAYS(NAMED_PLACE)
    return s;
}

real *estimator_array(estimator *s, const char *name, size_t *length)
{
    const size_t n = s->n, m = s->m, i = s->i, o = s->o, N = s->N, variables = s->variables, bends = s->bends;
    if (!strcmp(name, "remembered")) return *length = (size_t)(s->valid + 1 - s->state), s->state;
    ESTIMATOR_ARRAYS(NAMED_FIND)
    return horizon_array(s, name, length);
}

void estimator_use_transition(estimator *e, estimator_transition *transition, void *self)
{
    e->exact = transition, e->exact_self = self;
}

/* Return the standard deviation of a state at the start. */
static real first_sd(const estimator *e, size_t k)
{
    const size_t n = e->n;
    if (k >= e->N - e->o) return e->start_offset_sd[k - (e->N - e->o)];
    return e->start_sd[k < 3 * n ? k : 3 * n + (k - 3 * n) % 6 / 3];
}

void estimator_reset(estimator *e)
{
    const size_t N = e->N;
    memset(e->state, 0, (size_t)(e->valid + 1 - e->state) * sizeof(real));
    if (e->horizon) memset(e->horizon->frames, 0, e->horizon->remembered * sizeof(real));
    memcpy(e->state, e->start, e->n * sizeof(real));
    for (size_t k = 0; k < N; k++) {
        e->sd[k] = first_sd(e, k);
        e->covariance[k * N + k] = e->sd[k] * e->sd[k];
    }
    e->mean_innovation[0] = 1;
    e->status[0] = ESTIMATOR_WAITING;
    e->valid[0] = e->search[0] == 0;
    for (size_t j = 0; j < e->n; j++)
        if (!(e->sd[j] <= e->largest_sd[j])) e->valid[0] = 0;
}
