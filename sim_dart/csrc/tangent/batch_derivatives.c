#include "batch_derivatives.h"

#include "tangent.h"

#include <string.h>

#if HAS_CORE_TANGENT

#include "../blob/state.h"

/* Return the number of the states and inputs of a step. */
static size_t input_size(const core *c)
{
    return state_size(c) + (size_t)c->blob.counts.muscles + (size_t)c->blob.counts.dofs;
}

size_t core_batch_derivatives_size(const core *plain)
{
    return (input_size(plain) + state_size(plain) + (size_t)plain->blob.counts.dofs) * sizeof(double) +
           core_tangent_size(plain);
}

typedef struct {
    double h;
    int32_t steps, is_runge_kutta;
} rule;

/* Compute the change of the state at the end of a step by the `changes` of the inputs. */
static int differentiate(const core *c, void *scratch, const double *u, const double *extra, const rule *rule,
                         const double *changes, double *ends)
{
    const size_t n = (size_t)c->blob.counts.dofs, m = (size_t)c->blob.counts.muscles, x = state_size(c);
    core_tangent *t = core_tangent_open(c, scratch);
    core_tangent_set(t, TANGENT_Q, c->q, changes);
    core_tangent_set(t, TANGENT_QD, c->qd, changes + n);
    core_tangent_set(t, TANGENT_STATES, c->law_states, changes + 2 * n);
    core_tangent_set(t, TANGENT_COMMANDS, u, changes + x);
    core_tangent_set(t, TANGENT_TORQUES, extra, changes + x + m);
    int bad = core_tangent_move(t);
    if (!bad) bad = (rule->is_runge_kutta ? core_tangent_runge_kutta : core_tangent_step)(t, rule->h, rule->steps);
    core_tangent_changes(t, TANGENT_Q, ends);
    core_tangent_changes(t, TANGENT_QD, ends + n);
    core_tangent_changes(t, TANGENT_STATES, ends + 2 * n);
    return bad;
}

void core_batch_derivatives(const void *memory, size_t stride, int32_t count, void *scratch, const double *u,
                            const double *extra, double h, int32_t steps, int32_t is_runge_kutta, int32_t directions,
                            const int32_t *inputs, double *derivatives, int32_t *answers)
{
    const rule rule = {h, steps, is_runge_kutta};
    for (int32_t k = 0; k < count; k++) {
        const core *c = (const core *)(const void *)((const char *)memory + (size_t)k * stride);
        const size_t x = state_size(c), n = (size_t)c->blob.counts.dofs, width = (size_t)directions;
        double *changes = scratch, *ends = changes + input_size(c), *none = ends + x;
        memset(changes, 0, (input_size(c) + x + n) * sizeof(double));
        double *to = derivatives + (size_t)k * x * width;
        for (int32_t j = 0; j < directions && !answers[k]; j++) {
            changes[inputs[j]] = 1;
            const double *commands = u + (size_t)k * (size_t)c->blob.counts.muscles;
            const double *forces = extra ? extra + (size_t)k * n : none;
            answers[k] = differentiate(c, none + n, commands, forces, &rule, changes, ends);
            changes[inputs[j]] = 0;
            for (size_t i = 0; i < x; i++) to[i * width + (size_t)j] = ends[i];
        }
    }
}

#else
typedef int no_batch_derivatives; /* ISO C forbids empty translation units */
#endif
