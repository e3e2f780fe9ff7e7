#include "transition.h"

#include "tangent.h"

#include <string.h>

#if HAS_CORE_TANGENT

#include "../blob/state.h"

struct core_transition {
    core_tangent *tangent;
    const core *plain;
    size_t n, m, s;
    double *changes; /* a direction, and its result, each with the length of the longest array */
};

static size_t longest(size_t n, size_t m, size_t s)
{
    return (n > m ? n : m) + s + 1;
}

static size_t longest_in(const core *plain)
{
    return longest((size_t)plain->blob.counts.dofs, (size_t)plain->blob.counts.muscles, (size_t)plain->blob.law_states);
}

static size_t longest_of(const core_transition *t)
{
    return longest(t->n, t->m, t->s);
}

size_t core_transition_size(const core *plain)
{
    return sizeof(core_transition) + 2 * longest_in(plain) * sizeof(double) + core_tangent_size(plain);
}

core_transition *core_transition_open(const core *plain, void *memory)
{
    core_transition *t = memory;
    t->n = (size_t)plain->blob.counts.dofs, t->m = (size_t)plain->blob.counts.muscles;
    t->s = (size_t)plain->blob.law_states, t->plain = plain;
    t->changes = (double *)(void *)(t + 1);
    memset(t->changes, 0, 2 * longest_in(plain) * sizeof(double));
    t->tangent = core_tangent_open(plain, t->changes + 2 * longest_in(plain));
    return t;
}

/* Compute a column of A: the changes of q+ and qd+. */
static void read_column(const core_transition *t, size_t j, real *A)
{
    double *after = t->changes + longest_of(t);
    for (size_t half = 0; half < 2; half++) {
        core_tangent_changes(t->tangent, half ? TANGENT_QD : TANGENT_Q, after);
        for (size_t i = 0; i < t->n; i++) A[(half * t->n + i) * 2 * t->n + j] = after[i];
    }
    memset(after, 0, t->n * sizeof(double));
}

int core_transition_fill(void *self, const real *q, const real *qd, const real *f, const real *extra, real h, real *A)
{
    const core_transition *t = self;
    const size_t n = t->n;
    double *changes = t->changes, *none = changes + longest_of(t);
    core_tangent_set(t->tangent, TANGENT_COMMANDS, f, changes);
    core_tangent_set(t->tangent, TANGENT_TORQUES, extra, changes);
    if (t->plain->blob.counts.bends) core_tangent_set(t->tangent, TANGENT_STATES, t->plain->law_states, changes);
    for (size_t j = 0; j < 2 * n; j++) {
        changes[j % n] = 1;
        core_tangent_set(t->tangent, TANGENT_Q, q, j < n ? changes : none);
        core_tangent_set(t->tangent, TANGENT_QD, qd, j < n ? none : changes);
        changes[j % n] = 0;
        if (j <= n && core_tangent_move(t->tangent)) return 1; /* for velocities the core is already there */
        if (core_tangent_advance(t->tangent, h)) return 1;
        read_column(t, j, A);
    }
    return 0;
}

#else

size_t core_transition_size(const core *plain)
{
    (void)plain;
    return 0;
}

core_transition *core_transition_open(const core *plain, void *memory)
{
    (void)plain, (void)memory;
    return NULL;
}

int core_transition_fill(void *self, const real *q, const real *qd, const real *f, const real *extra, real h, real *A)
{
    (void)self, (void)q, (void)qd, (void)f, (void)extra, (void)h, (void)A;
    return 1;
}

#endif
