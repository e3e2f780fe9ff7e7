/* The core compiled again for numbers with a tangent, as one translation unit of static functions; and the
   functions of tangent.h, with plain numbers as input and tangents as output. */
#include "support.h"

#if HAS_CORE_TANGENT

#define CARDSFLOW_TANGENT

/* Complex products and quotients by the elementary formulas, since infinities do not occur; and optimisation
   for size, since arithmetic limits the speed. */
#if defined(__clang__)
#pragma STDC CX_LIMITED_RANGE ON
#pragma clang attribute push(__attribute__((minsize)), apply_to = function)
#elif defined(__GNUC__) && defined(__OPTIMIZE__)
#pragma GCC optimize("cx-limited-range", "Os")
#endif
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function" /* part of the core is unused */
#endif

#include "tangent.h"

#include "../math/root.c"
#include "../kinematics/joint_variables.c"
#include "../kinematics/tree.c"
#include "../kinematics/bodies.c"
#include "../kinematics/tasks.c"
#include "../paths/wrap_inside.c"
#include "../paths/ellipsoid/geodesic.c"
#include "../paths/ellipsoid/fan.c"
#include "../paths/ellipsoid/shot.c"
#include "../paths/ellipsoid/ellipsoid.c"
#include "../paths/wrap_simd.c"
#include "../paths/wrap.c"
#include "../paths/pulley.c"
#include "../paths/multi_wrap.c"
#include "../paths/routed/wrap_rules.c"
#include "../paths/routed/route_wraps.c"
#include "../paths/routed/routed.c"
#include "../paths/span.c"
#include "../paths/structure/structure.c"
#include "../paths/structure/straight.c"
#include "../paths/paths.c"
#include "../../generated/law_sources.h"
#include "../cable_friction/bends.c"
#include "../cable_friction/cable_stretch.c"
#include "../cable_friction/cable_friction.c"
#include "../laws/drive.c"
#include "../laws/laws.c"
#include "../dynamics/energies.c"
#include "../dynamics/external_wrenches.c"
#include "../dynamics/inverse.c"
#include "../dynamics/dense.c"
#include "../dynamics/forward.c"
#include "../loops/closures.c"
#include "../loops/loops.c"
#include "../dynamics/limits.c"
#include "../dynamics/friction.c"
#include "../integrators/move.c"
#include "../integrators/state_rates.c"
#include "../integrators/runge_kutta.c"
#include "../integrators/continuous_time.c"
#include "../integrators/semi_implicit_euler.c"

/* e of complex_step.h */
static const double SMALL = 0x1p-332, PER_SMALL = 0x1p332;

struct core_tangent {
    core *core;
    real *external_wrench, *torques;
    int has_torques, has_law_changes;
};

size_t core_tangent_size(const core *plain)
{
    const size_t numbers = state_reals(&plain->blob) + blob_reals(&plain->blob);
    return sizeof(core_tangent) + sizeof(core) + 
           (numbers + 9 * (size_t)plain->externals + (size_t)plain->blob.counts.dofs) * sizeof(real);
}

static real *widen(real *to, const void *plain, size_t count)
{
    const double *from = plain;
    for (size_t k = 0; k < count; k++) to[k] = from[k];
    return to + count;
}

/* Copy the plain handle, except for the numbers at its pointers. */
static core *copy(const core *plain, void *memory)
{
    core *c = memory;
    STATE_LENGTHS(&plain->blob)
    *c = *plain;
    real *at = (real *)(void *)(c + 1);
#define PLACE(name, length) c->name = at, at = widen(at, plain->name, length);
    STATE_ARRAYS(PLACE)
#undef PLACE
#define TAKE_int32_t(name, count)
#define TAKE_real(name, count) c->blob.name = at, at = widen(at, plain->blob.name, (size_t)(count));
#define TAKE_FIELD(type, name, per_item, count) TAKE_##type(name, per_item * n->count)
    BLOB_FIELDS(TAKE_FIELD)
#undef TAKE_FIELD
    return c;
}

core_tangent *core_tangent_open(const core *plain, void *memory)
{
    core_tangent *t = memory;
    const size_t externals = (size_t)plain->externals;
    real *point = (real *)(void *)(t + 1);
    t->external_wrench = widen(point, plain->external_point, 3 * externals);
    t->torques = widen(t->external_wrench, plain->external_wrench, 6 * externals);
    t->has_torques = t->has_law_changes = 0;
    t->core = copy(plain, t->torques + plain->blob.counts.dofs);
    core_external_wrenches(t->core, plain->externals, plain->external_frame, point, t->external_wrench);
    return t;
}

/* Return an array and its length. */
static real *array(const core_tangent *t, enum tangent_array which, size_t *length)
{
    const core *c = t->core;
    STATE_LENGTHS(&c->blob)
    (void)closures;
    (void)law_constants, (void)points, (void)surfaces, (void)wraps, (void)pulleys;
    (void)frames, (void)terms, (void)wide, (void)variables, (void)conditions, (void)moves;
    const struct {
        real *numbers;
        size_t length;
    } arrays[] = {
        [TANGENT_Q] = {c->q, dofs},
        [TANGENT_QD] = {c->qd, dofs},
        [TANGENT_QDD] = {c->qdd, dofs},
        [TANGENT_HELD] = {c->held, dofs},
        [TANGENT_HOLD_FORCES] = {c->hold_force, dofs},
        [TANGENT_STATES] = {c->law_states, law_states},
        [TANGENT_STATE_RATES] = {c->law_rates, law_states},
        [TANGENT_COMMANDS] = {c->commands, muscles},
        [TANGENT_TORQUES] = {t->torques, dofs},
        [TANGENT_WRENCHES] = {t->external_wrench, 6 * (size_t)c->externals},
        [TANGENT_LENGTHS] = {c->lengths, muscles},
        [TANGENT_TASKS] = {c->task_values, 3 * tasks},
        [TANGENT_TENSIONS] = {c->tensions, muscles},
        [TANGENT_FAR_TENSIONS] = {c->far_tensions, bends ? muscles : 0},
        [TANGENT_WORK] = {c->work, 4},
        [TANGENT_ENERGIES] = {c->energies, 3},
        [TANGENT_MOMENTA] = {c->momenta, 6},
    };
    *length = arrays[which].length;
    return arrays[which].numbers;
}

void core_tangent_set(core_tangent *t, enum tangent_array which, const double *values, const double *changes)
{
    size_t length;
    real *numbers = array(t, which, &length);
    t->has_torques |= which == TANGENT_TORQUES;
    for (size_t k = 0; k < length; k++) numbers[k] = with_tangent(values[k], SMALL * changes[k]);
}

void core_tangent_changes(const core_tangent *t, enum tangent_array which, double *changes)
{
    size_t length;
    const real *numbers = array(t, which, &length);
    for (size_t k = 0; k < length; k++) changes[k] = PER_SMALL * tangent_of(numbers[k]);
}

void core_tangent_values(const core_tangent *t, enum tangent_array which, double *values)
{
    size_t length;
    const real *numbers = array(t, which, &length);
    for (size_t k = 0; k < length; k++) values[k] = value_of(numbers[k]);
}

size_t core_tangent_robot_numbers(const core *plain)
{
    return blob_reals(&plain->blob);
}

/* Return whether parameters of muscle laws change along a direction. */
static int law_changes(const core *c)
{
    for (int32_t k = 0; k < c->blob.counts.law_parameters; k++)
        if (tangent_of(c->blob.law_parameter[k]) != 0) return 1;
    return 0;
}

/* The numbers of the blob belong to this handle (see copy), in the order of the fields. Quantities derived
   from them are computed again; the constants of muscle laws, which take longer, only if they change. */
void core_tangent_change_robot(core_tangent *t, const double *changes)
{
    core *c = t->core;
    const blob_counts *n = &c->blob.counts;
#define CHANGE_int32_t(name, count)
#define CHANGE_real(name, count)                                                                                       \
    for (real *at = (real *)c->blob.name, *end = at + (count); at < end; at++, changes++)                              \
        *at = with_tangent(value_of(*at), SMALL * *changes);
#define CHANGE_FIELD(type, name, per_item, count) CHANGE_##type(name, (size_t)(per_item * n->count))
    BLOB_FIELDS(CHANGE_FIELD)
#undef CHANGE_FIELD
    tree_prepare(c);
    paths_prepare(c);
    const int has_law_changes = law_changes(c);
    if (has_law_changes || t->has_law_changes) laws_prepare(c);
    t->has_law_changes = has_law_changes;
}

int core_tangent_move(core_tangent *t)
{
    return core_move_checked(t->core, t->core->q, t->core->qd);
}

int core_tangent_start(core_tangent *t)
{
    return core_start(t->core, t->core->commands);
}

int core_tangent_drive(core_tangent *t)
{
    return core_drive(t->core, t->core->qd, t->core->commands);
}

void core_tangent_energies(core_tangent *t)
{
    core_energies(t->core, t->core->qd);
}

static const real *torques(const core_tangent *t)
{
    return t->has_torques ? t->torques : NULL;
}

int core_tangent_step(core_tangent *t, double h, int32_t steps)
{
    return core_step(t->core, t->core->commands, torques(t), h, steps);
}

int core_tangent_runge_kutta(core_tangent *t, double h, int32_t steps)
{
    return core_runge_kutta(t->core, t->core->commands, torques(t), h, steps);
}

int core_tangent_derivative(core_tangent *t)
{
    return core_derivative(t->core, t->core->commands, torques(t));
}

int core_tangent_advance(core_tangent *t, double h)
{
    core *c = t->core;
    const int bad = muscles_pull(c, c->commands);
    if (bad) return -bad;
    external_wrenches_add(c, torques(t));
    find_velocities(c, h);
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) c->q[j] += h * c->qd[j];
    return 0;
}

#include "directions.c"

#if defined(__clang__)
#pragma clang attribute pop
#endif
#else
#include "tangent.h" /* ISO C forbids empty translation units */
#endif
