/* The estimator handle: its memory, its arrays, and the start. */
#include "horizon/frames.h"

#include <string.h>

#define ESTIMATOR_LENGTHS(c, imus)                                                                     \
    const size_t n = (size_t)(c)->blob.counts.dofs, m = (size_t)(c)->blob.counts.muscles;              \
    const size_t variables = (size_t)(c)->blob.counts.variables, bends = (size_t)(c)->blob.counts.bends;       \
    const size_t i = (size_t)(imus), N = 3 * n + 6 * i;

/* The arrays after a handle begin at a multiple of 8 bytes, also where pointers have 4 bytes. */
static const size_t HANDLE_SIZE = (sizeof(estimator) + 7u) / 8u * 8u;

size_t estimator_size(const core *c, int32_t imus)
{
    if (imus < 0 || imus > MAX_IMUS) return 0;
    ESTIMATOR_LENGTHS(c, imus)
    size_t reals = 0;
#define ADD_LENGTH(name, length) reals += length;
    ESTIMATOR_ARRAYS(ADD_LENGTH)
#undef ADD_LENGTH
    return HANDLE_SIZE + reals * sizeof(real);
}

estimator *estimator_open(core *c, int32_t imus, const int32_t *imu_frame, void *memory)
{
    const size_t size = estimator_size(c, imus);
    if (!size || !memory || (uintptr_t)memory % 8) return NULL;
    for (int32_t k = 0; k < imus; k++)
        if (imu_frame[k] < 0 || imu_frame[k] >= c->blob.counts.frames) return NULL;
    memset(memory, 0, size);
    ESTIMATOR_LENGTHS(c, imus)
    estimator *e = memory;
    e->core = c, e->imu_frame = imu_frame;
    e->n = n, e->m = m, e->i = i, e->N = N, e->variables = variables, e->bends = bends;
    real *at = (real *)(void *)((char *)memory + HANDLE_SIZE);
#define PLACE(name, length) e->name = at, at += length;
    ESTIMATOR_ARRAYS(PLACE)
#undef PLACE
    return e;
}

real *estimator_array(estimator *e, const char *name, size_t *length)
{
    const size_t n = e->n, m = e->m, i = e->i, N = e->N, variables = e->variables, bends = e->bends;
    if (!strcmp(name, "remembered")) return *length = (size_t)(e->valid + 1 - e->state), e->state;
#define FIND(name_, length_)                                                                           \
    if (!strcmp(name, #name_)) return *length = length_, e->name_;
    ESTIMATOR_ARRAYS(FIND)
#undef FIND
    return horizon_array(e, name, length);
}

void estimator_use_transition(estimator *e, estimator_transition *transition, void *self)
{
    e->exact = transition, e->exact_self = self;
}

/* Return the standard deviation of a state at the start. */
static real first_sd(const estimator *e, size_t k)
{
    const size_t n = e->n;
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
