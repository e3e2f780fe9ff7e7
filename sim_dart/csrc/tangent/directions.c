/* Part of tangent.c: derivatives of rates along single coordinates, velocities and numbers of muscle laws. */
#include "support.h"

#if HAS_CORE_TANGENT && defined(CARDSFLOW_TANGENT)

static void put(real *to, const double *from, size_t count)
{
    for (size_t k = 0; k < count; k++) to[k] = from[k];
}

static void take_changes(const real *from, size_t count, double *to)
{
    for (size_t k = 0; k < count; k++) to[k] = PER_SMALL * tangent_of(from[k]);
}

/* Change a number along itself, or end this. */
static void change(real *number, double size)
{
    *number = with_tangent(__real__ *number, SMALL * size);
}

static size_t dofs_of(const core_tangent *t)
{
    return (size_t)t->core->blob.counts.dofs;
}

void core_tangent_place(core_tangent *t, const core *plain, const double *commands, const double *torques)
{
    core *c = t->core;
    const size_t n = dofs_of(t), m = (size_t)c->blob.counts.muscles, wraps = (size_t)c->blob.counts.wraps;
    const real *from[] = {plain->q, plain->qd, plain->law_states, plain->lengths, plain->rates, plain->stored_path,
                          plain->jacobian, plain->wrap_before, plain->wrap_rank, plain->wrap_turn};
    real *const to[] = {c->q, c->qd, c->law_states, c->lengths, c->rates, c->stored_path,
                        c->jacobian, c->wrap_before, c->wrap_rank, c->wrap_turn};
    const size_t lengths[] = {n, n, (size_t)c->blob.law_states, m, m, PATH_NUMBERS * wraps, m * n, wraps, wraps, wraps};
    for (size_t k = 0; k < sizeof lengths / sizeof *lengths; k++) put(to[k], (const void *)from[k], lengths[k]);
    put(c->commands, commands, m);
    put(t->torques, torques, n);
    put(c->torques, (const void *)plain->torques, n);
    for (size_t k = 0; k < m; k++) c->tensions[k] = ((const double *)(const void *)plain->tensions)[k];
    if (!c->has_laws)
        for (size_t k = 0; k < m; k++) c->tensions[k] = c->tension_scale[k] * larger(c->commands[k], 0);
    t->has_torques = 1;
    c->is_settling = plain->is_settling;
    if (c->has_weight) core_move(c, c->q);
    else tree_move(c, c->q);
}

/* Compute a column of the derivatives of a muscle, along input j, which has a change. */
static void take_column(const core *c, const muscle_law *at, int32_t j, double *column)
{
    const int is_hill = at->law->is_hill, has_activation_only = is_hill && (at->states == 1 || c->is_settling);
    real rates[MAX_LAW_STATES] = {0};
    const real l = c->lengths[at->m], v = c->rates[at->m], u = command(at, c->commands);
    if (!is_hill || j != LAW_BY_COMMAND) column[0] = PER_SMALL * tangent_of(bounded_tension(at, at->x, l, v, u));
    if (has_activation_only && j < LAW_BY_COMMAND) return;
    if (c->is_settling && has_fibre(at)) rates[0] = activation_rate(at->k, at->x[0], u);
    else if (at->states) at->law->rates(at->k, at->x, l, v, u, rates);
    for (int32_t i = 0; i < at->states; i++) column[(1 + i) * LAW_INPUTS] = PER_SMALL * tangent_of(rates[i]);
}

static void take_columns(core *c, const muscle_law *at, double *partials)
{
    real *numbers[LAW_INPUTS] = {c->lengths + at->m, c->rates + at->m, c->commands + at->m};
    const int is_ideal = c->blob.law_kind[at->m] == KIND_ideal;
    for (int32_t i = 0; i < at->states; i++) numbers[LAW_BY_STATES + i] = at->x + i;
    const int32_t first = is_ideal ? LAW_BY_COMMAND : at->law->place ? LAW_BY_RATE : LAW_BY_LENGTH;
    for (int32_t j = first; j < LAW_BY_STATES + at->states; j++) {
        if (j == LAW_BY_COMMAND && !at->entry->driven) continue;
        change(numbers[j], 1);
        take_column(c, at, j, partials + j);
        change(numbers[j], 0);
    }
}

void core_tangent_laws(core_tangent *t, double *partials)
{
    muscle_law at;
    memset(partials, 0, (size_t)t->core->blob.counts.muscles * LAW_PARTIALS * sizeof(double));
    for EACH_MUSCLE (t->core, &at) {
        take_columns(t->core, &at, partials);
        partials[LAW_STATE_COUNT] = at.states;
        partials += LAW_PARTIALS;
    }
}

void core_tangent_weight_along_command(core_tangent *t, size_t muscle, double *torques)
{
    core *c = t->core;
    memset(torques, 0, dofs_of(t) * sizeof(double));
    if (!LAW_TABLE[c->blob.law_kind[muscle]].law->weigh) return;
    for (size_t j = 0; j < dofs_of(t); j++) change(c->torques + j, 0);
    change(c->commands + muscle, 1);
    add_weights(c, c->commands);
    change(c->commands + muscle, 0);
    take_changes(c->torques, dofs_of(t), torques);
}

void core_tangent_accelerate_along_qd(core_tangent *t, size_t coordinate, double *qdd)
{
    core *c = t->core;
    change(c->qd + coordinate, 1);
    state_rates_accelerate(c, t->torques);
    change(c->qd + coordinate, 0);
    take_changes(c->qdd, dofs_of(t), qdd);
}

/* Compute the tensions of heavy cables at constant rates, since they depend on positions. */
static void pull_heavy(core *c)
{
    muscle_law at;
    for EACH_MUSCLE (c, &at)
        if (at.law->place)
            c->tensions[at.m] = bounded_tension(&at, at.x, c->lengths[at.m], value_of(c->rates[at.m]), command(&at, c->commands));
}

void core_tangent_accelerate_along_q(core_tangent *t, size_t coordinate, double *qdd, double *rates)
{
    core *c = t->core;
    change(c->q + coordinate, 1);
    tree_move(c, c->q);
    c->moving = 1 + (int32_t)coordinate;
    paths_move(c);
    c->moving = 0;
    if (c->has_laws) core_rates(c, c->qd);
    if (c->has_weight) {
        laws_place(c);
        pull_heavy(c);
    }
    add_torques(c);
    if (c->has_weight) add_weights(c, c->commands);
    state_rates_accelerate(c, t->torques);
    change(c->q + coordinate, 0);
    take_changes(c->qdd, dofs_of(t), qdd);
    if (c->has_laws) take_changes(c->rates, (size_t)c->blob.counts.muscles, rates);
}

void core_tangent_close_along(core_tangent *t, const core *plain, size_t j, double *state)
{
    core *c = t->core;
    const size_t n = dofs_of(t);
    put(c->q, (const void *)plain->q, n);
    put(c->qd, (const void *)plain->qd, n);
    change(j < n ? c->q + j : c->qd + (j - n), 1);
    core_move(c, c->q);
    loops_close(c);
    take_changes(c->q, n, state);
    take_changes(c->qd, n, state + n);
}

#else
typedef int no_directions; /* ISO C forbids empty translation units */
#endif
