#include "shooting.h"

#include "tangent.h"

#include <string.h>

#if HAS_CORE_TANGENT

#include "../blob/state.h"

struct core_shooting {
    core *plain;
    core_tangent *tangent;
    size_t n, m, states, width; /* width: numbers in a state */
    double *changes, *end;      /* changes of all inputs; an end and its changes */
};

static size_t width(const core *plain)
{
    return 2 * (size_t)plain->blob.counts.dofs + (size_t)plain->blob.law_states;
}

static size_t own_numbers(const core *plain)
{
    const size_t controls = (size_t)plain->blob.counts.muscles + (size_t)plain->blob.counts.dofs;
    return 2 * width(plain) + controls + 1;
}

size_t core_shooting_size(const core *plain)
{
    return sizeof(core_shooting) + own_numbers(plain) * sizeof(double) + core_tangent_size(plain);
}

core_shooting *core_shooting_open(core *plain, void *memory)
{
    core_shooting *s = memory;
    s->plain = plain;
    s->n = (size_t)plain->blob.counts.dofs, s->m = (size_t)plain->blob.counts.muscles;
    s->states = (size_t)plain->blob.law_states, s->width = width(plain);
    s->changes = (double *)(void *)(s + 1);
    memset(s->changes, 0, own_numbers(plain) * sizeof(double));
    s->end = s->changes + own_numbers(plain) - s->width;
    s->tangent = core_tangent_open(plain, s->end + s->width);
    return s;
}

/* Read q, qd and law_states, or their changes. */
static void read_end(const core_shooting *s, void (*get)(const core_tangent *, enum tangent_array, double *), double *to)
{
    get(s->tangent, TANGENT_Q, to);
    get(s->tangent, TANGENT_QD, to + s->n);
    get(s->tangent, TANGENT_STATES, to + 2 * s->n);
}

/* Simulate an interval with the changes in s->changes. */
static int simulate(core_shooting *s, int32_t steps, double h, const double *start, const double *controls)
{
    core_tangent *t = s->tangent;
    const double *d = s->changes;
    core_tangent_set(t, TANGENT_Q, start, d);
    core_tangent_set(t, TANGENT_QD, start + s->n, d + s->n);
    core_tangent_set(t, TANGENT_STATES, start + 2 * s->n, d + 2 * s->n);
    core_tangent_set(t, TANGENT_COMMANDS, controls, d + s->width);
    core_tangent_set(t, TANGENT_TORQUES, controls + s->m, d + s->width + s->m);
    if (core_tangent_move(t)) return 1;
    return core_tangent_runge_kutta_along(t, h, d[s->width + s->m + s->n], steps);
}

/* Simulate an interval without derivatives. */
static int simulate_plain(const core_shooting *s, int32_t steps, double h, const double *start, const double *controls,
                          double *end)
{
    core *c = s->plain;
    memcpy(c->q, start, s->n * sizeof(double));
    memcpy(c->qd, start + s->n, s->n * sizeof(double));
    memcpy(c->law_states, start + 2 * s->n, s->states * sizeof(double));
    if (core_move_checked(c, c->q, c->qd) || core_runge_kutta(c, controls, controls + s->m, h, steps)) return 1;
    memcpy(end, c->q, s->n * sizeof(double));
    memcpy(end + s->n, c->qd, s->n * sizeof(double));
    memcpy(end + 2 * s->n, c->law_states, s->states * sizeof(double));
    return 0;
}

int core_shooting_run(core_shooting *s, int32_t count, int32_t steps, const double *h, const double *starts,
                      const double *controls, int32_t directions, const int32_t *inputs, double *ends,
                      double *derivatives)
{
    const size_t across = (size_t)directions;
    for (int32_t k = 0; k < count; k++) {
        const double *start = starts + (size_t)k * s->width, *own = controls + (size_t)k * (s->m + s->n);
        double *end = ends + (size_t)k * s->width, *rows = derivatives + (size_t)k * s->width * across;
        if (!across && simulate_plain(s, steps, h[k], start, own, end)) return 1 + k;
        for (size_t j = 0; j < across; j++) {
            s->changes[inputs[j]] = 1;
            const int bad = simulate(s, steps, h[k], start, own);
            s->changes[inputs[j]] = 0;
            if (bad) return 1 + k;
            read_end(s, core_tangent_changes, s->end);
            for (size_t i = 0; i < s->width; i++) rows[i * across + j] = s->end[i];
            if (!j) read_end(s, core_tangent_values, end);
        }
    }
    return 0;
}

#else

size_t core_shooting_size(const core *plain)
{
    (void)plain;
    return 0;
}

core_shooting *core_shooting_open(core *plain, void *memory)
{
    (void)plain, (void)memory;
    return NULL;
}

int core_shooting_run(core_shooting *s, int32_t count, int32_t steps, const double *h, const double *starts,
                      const double *controls, int32_t directions, const int32_t *inputs, double *ends,
                      double *derivatives)
{
    (void)s, (void)count, (void)steps, (void)h, (void)starts, (void)controls, (void)directions, (void)inputs;
    (void)ends, (void)derivatives;
    return 1;
}

#endif
