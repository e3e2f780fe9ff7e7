#include "batch.h"

#include "lanes.h"

#include "../blob/state.h"

#include <string.h>

static core *instance(void *memory, size_t stride, int32_t k)
{
    return (core *)(void *)((char *)memory + (size_t)k * stride);
}

static const real *row(const real *rows, int32_t k, int32_t width)
{
    return rows ? rows + (size_t)k * (size_t)width : NULL;
}

/* Return the size of the memory of a group of lanes, which ends where another one can begin. */
static size_t size_of(const batch_lanes *lanes, const core *c)
{
    return (lanes->size(c) + 63) / 64 * 64;
}

size_t core_batch_group_size(const core *c)
{
    size_t size = 0;
    for (const batch_lanes *lanes = batch_lanes_for(c); lanes; lanes = lanes->narrower) size += size_of(lanes, c);
    return size;
}

/* Instances that wait for a group to be complete. */
typedef struct {
    int32_t count, index[MAX_LANES];
    core *handle[MAX_LANES];
    const real *u[MAX_LANES], *extra[MAX_LANES];
} waiting;

/* Step the waiting instances in the largest groups that they fill, and the others alone. */
static void step_waiting(waiting *w, char *memory, int has_extra, real h, int32_t steps, int32_t *answers)
{
    int32_t i = 0, result[MAX_LANES];
    if (!w->count) return;
    for (const batch_lanes *lanes = batch_lanes_for(w->handle[0]); lanes; lanes = lanes->narrower) {
        for (; w->count - i >= lanes->count; i += lanes->count)
            lanes->step(memory, w->handle + i, w->u + i, has_extra ? w->extra + i : NULL, h, steps, result + i);
        memory += size_of(lanes, w->handle[0]);
    }
    for (; i < w->count; i++) result[i] = core_step(w->handle[i], w->u[i], w->extra[i], h, steps);
    for (i = 0; i < w->count; i++) answers[w->index[i]] = result[i];
    w->count = 0;
}

void core_batch_step(void *memory, size_t stride, int32_t count, const uint8_t *chosen, const real *u, const real *extra,
                     real h, int32_t steps, int32_t is_runge_kutta, void *group, int32_t *answers)
{
    waiting w;
    w.count = 0;
    for (int32_t k = 0; k < count; k++) {
        core *c = instance(memory, stride, k);
        const blob_counts *n = &c->blob.counts;
        const real *commands = row(u, k, n->muscles), *outer = row(extra, k, n->dofs);
        if (answers[k] || (chosen && !chosen[k])) continue;
        if (!group || is_runge_kutta) {
            answers[k] = (is_runge_kutta ? core_runge_kutta : core_step)(c, commands, outer, h, steps);
            continue;
        }
        w.index[w.count] = k, w.handle[w.count] = c, w.u[w.count] = commands, w.extra[w.count++] = outer;
        if (w.count == MAX_LANES) step_waiting(&w, group, extra != NULL, h, steps, answers);
    }
    step_waiting(&w, group, extra != NULL, h, steps, answers);
}

static int reset(core *c, const real *q, const real *qd, const real *u)
{
    const size_t size = (size_t)c->blob.counts.dofs * sizeof(real);
    int bad = core_move_checked(c, q, qd);
    if (bad) return bad;
    memcpy(c->q, q, size), memcpy(c->qd, qd, size);
    if (c->blob.counts.closures) {
        bad = core_close(c, NULL, c->q);
        if (bad) return -bad;
        core_close_rates(c, c->qd);
    }
    if (u) return core_start(c, u);
    memset(c->law_states, 0, (size_t)c->blob.law_states * sizeof(real));
    return 0;
}

void core_batch_reset(void *memory, size_t stride, int32_t count, const uint8_t *chosen, const real *q, const real *qd,
                      const real *u, int32_t *answers)
{
    for (int32_t k = 0; k < count; k++) {
        core *c = instance(memory, stride, k);
        const blob_counts *n = &c->blob.counts;
        if (chosen[k]) answers[k] = reset(c, row(q, k, n->dofs), row(qd, k, n->dofs), row(u, k, n->muscles));
    }
}

void core_batch_terms(void *memory, size_t stride, int32_t count, int32_t which, const real *u)
{
    for (int32_t k = 0; k < count; k++) {
        core *c = instance(memory, stride, k);
        if (which & BATCH_MASS_MATRIX) core_mass_matrix(c);
        if (which & BATCH_BIAS) core_bias(c, c->qd);
        if (which & BATCH_TASK_JACOBIAN) core_task_jacobian(c);
        if (which & BATCH_TENSIONS) core_drive(c, c->qd, row(u, k, c->blob.counts.muscles));
    }
}
