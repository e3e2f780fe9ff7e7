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

size_t core_batch_group_size(const core *c)
{
    const batch_lanes *lanes = batch_lanes_for(c);
    return lanes ? lanes->size(c) : 0;
}

/* Instances that wait for a group to be complete. */
typedef struct {
    int32_t count, index[LANES_OF_BATCH];
    core *handle[LANES_OF_BATCH];
    const real *u[LANES_OF_BATCH], *extra[LANES_OF_BATCH];
} waiting;

static void step_group(waiting *w, void *group, int has_extra, real h, int32_t steps, int32_t *answers)
{
    int32_t found[LANES_OF_BATCH];
    batch_lanes_for(w->handle[0])->step(group, w->handle, w->u, has_extra ? w->extra : NULL, h, steps, found);
    for (int32_t i = 0; i < LANES_OF_BATCH; i++) answers[w->index[i]] = found[i];
    w->count = 0;
}

void core_batch_step(void *memory, size_t stride, int32_t count, const real *u, const real *extra, real h, int32_t steps,
                     int32_t is_runge_kutta, void *group, int32_t *answers)
{
    waiting w;
    w.count = 0;
    for (int32_t k = 0; k < count; k++) {
        core *c = instance(memory, stride, k);
        const blob_counts *n = &c->blob.counts;
        const real *own = row(u, k, n->muscles), *outer = row(extra, k, n->dofs);
        if (answers[k]) continue;
        if (!group || is_runge_kutta) {
            answers[k] = (is_runge_kutta ? core_runge_kutta : core_step)(c, own, outer, h, steps);
            continue;
        }
        w.index[w.count] = k, w.handle[w.count] = c, w.u[w.count] = own, w.extra[w.count++] = outer;
        if (w.count == LANES_OF_BATCH) step_group(&w, group, extra != NULL, h, steps, answers);
    }
    for (int32_t i = 0; i < w.count; i++) answers[w.index[i]] = core_step(w.handle[i], w.u[i], w.extra[i], h, steps);
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

void core_batch_reset(void *memory, size_t stride, int32_t count, const int32_t *chosen, const real *q, const real *qd,
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
        if (which & BATCH_ENERGIES) core_energies(c, c->qd);
    }
}
