/* The core compiled again for numbers of several instances, as one translation unit of static functions; and
   the functions of lanes.h.

   The instances of a group are copied to the lanes of one handle, which does the substeps, and back. An instance
   that needs another decision than the others leaves: it repeats this substep, and does the rest, alone. Limits,
   which few instances meet at a time, are computed alone as well. */
#include "lane_support.h"

#if HAS_LANES

#if !defined(LANES_NAME)
#define LANES_NAME BATCH_LANES
#define LANES_NARROWER NULL
#endif
#define CARDSFLOW_LANES
#define CARDSFLOW_PARTS "batch/lane_parts.h"

#pragma GCC diagnostic ignored "-Wunused-function" /* part of the core is unused */
#pragma GCC diagnostic ignored "-Wpsabi"           /* vectors as arguments of static functions */

#include "../cable_friction/cable_friction.h"
#include "../cable_friction/cable_stretch.h"
#include "../dynamics/dense.h"
#include "../dynamics/friction.h"
#include "../dynamics/limits.h"
#include "../kinematics/joint_variables.h"
#include "../laws/hill/activation.h"
#include "../loops/loops.h"
#include "alone.h"
#include "lanes.h"

#include <stddef.h>
#include <string.h>

_Static_assert(GROUP <= MAX_LANES, "MAX_LANES is wrong");

/* Functions for parts that qualifying robots do not have. */
#define variables_move(c) ((void)(c))
#define variables_rates(c, qd) (qd)
#define variables_follow(c, qd, rates) ((void)(rates))
#define variables_fold(c, row, reduced) ((void)(row))
#define dense_factor(c, armature) ((void)(c))
#define dense_solve(c, x) ((void)(c))
#define dense_accelerate(c, qd, tau, armature) ((void)(c))
#define friction_enforce(c, h) ((void)(c))
#define loops_enforce(c, h) ((void)(c))
#define cable_friction_begin(c, h) ((void)(c))
#define cable_friction_has_converged(c, h) 1
#define cable_friction_pull(c) ((void)(c))
#define cable_friction_rates(c, qd) ((void)(c))
#define cable_friction_state_rates(c) ((void)(c))
#define cable_friction_advance(c, h) ((void)(c))
#define cable_friction_start(c) ((void)(c))
#define cable_stretch_take(c, m, bend, found) ((void)(bend), (void)(found))
#define cable_stretch_start(c) ((void)(c))
#define activation_rate(k, a, u) (u)
#define activations_add(s, k, a, u, h) ((void)(k))
#define activations_finish(s, h) ((void)(s))

#define limits_enforce_softly(c, h) ((void)(c))
#define limits_enforce(c, rates) enforce_alone(c, passes)
static void enforce_alone(core *c, truth passes);

#include "../kinematics/bodies.c"
#include "../kinematics/tasks.c"
#include "../kinematics/tree.c"
#include "../paths/span.c"
#include "../paths/structure/straight.c"
#define paths_move straight_move
#include "../dynamics/external_wrenches.c"
#include "../dynamics/forward.c"
#include "../laws/elastic_cable.c"
#include "../laws/ideal.c"
#include "../laws/passive_spring.c"
#include "../laws/path_spring.c"
#include "../laws/tendon_spring.c"
#include "../laws/drive.c"
#include "../integrators/move.c"
#include "../integrators/semi_implicit_euler.c"

/* A group; plain handles have the type of the handle in lanes, but pointers to plain numbers. */
typedef struct {
    core lanes;
    core *handle[GROUP];
    const real *blob_numbers[GROUP]; /* identify the blobs whose constants are in the lanes */
    int32_t leaving;
    real *u, *extra, *before;
    real *numbers;
} group;

/* Lengths of the arrays of the working memory, by name. */
#define LENGTH_MEMBER(name, length) size_t name;
typedef struct {
    STATE_ARRAYS(LENGTH_MEMBER)
} array_lengths;
#undef LENGTH_MEMBER

/* An array of the working memory: where a handle has its address, and array_lengths its length. */
typedef struct {
    size_t array, length;
} array_place;

#define PLACE_OF(name) {offsetof(core, name), offsetof(array_lengths, name)}

static const array_place CONSTANTS[] = {PLACE_OF(rotation_sin), PLACE_OF(rotation_cos), PLACE_OF(fixed_length),
                                        PLACE_OF(column_first), PLACE_OF(column_end),   PLACE_OF(law_constants)};

/* State at the start of a step. */
static const array_place STARTS[] = {PLACE_OF(rotation), PLACE_OF(origin),  PLACE_OF(axis),     PLACE_OF(at),
                                     PLACE_OF(q),        PLACE_OF(qd),      PLACE_OF(lengths),  PLACE_OF(jacobian),
                                     PLACE_OF(law_states), PLACE_OF(tension_scale)};

static const array_place RESULTS[] = {
    PLACE_OF(rotation), PLACE_OF(origin),     PLACE_OF(axis),  PLACE_OF(at),          PLACE_OF(q),       PLACE_OF(qd),
    PLACE_OF(lengths),  PLACE_OF(jacobian),   PLACE_OF(point), PLACE_OF(task_values), PLACE_OF(torques), PLACE_OF(rates),
    PLACE_OF(tensions), PLACE_OF(law_states), PLACE_OF(qdd),   PLACE_OF(outer),       PLACE_OF(work)};

/* What joint limits need. */
static const array_place LIMITS[] = {PLACE_OF(link),     PLACE_OF(axis),  PLACE_OF(centre), PLACE_OF(moment),
                                     PLACE_OF(reaction), PLACE_OF(pivot), PLACE_OF(qd),     PLACE_OF(low),
                                     PLACE_OF(high)};

#define SIZE(places) (sizeof places / sizeof *places)

static void find_lengths(const blob_view *view, array_lengths *of)
{
    STATE_LENGTHS(view)
#define SET_LENGTH(name, length) of->name = length;
    STATE_ARRAYS(SET_LENGTH)
#undef SET_LENGTH
}

static int qualifies(const core *c)
{
    const blob_counts *n = &c->blob.counts;
    if (!c->is_straight || n->closures || n->variables != n->dofs || c->has_friction || c->has_soft_limits || c->externals)
        return 0;
    for (int32_t m = 0; m < n->muscles; m++)
        if (!LAW_TABLE[c->blob.law_kind[m]].law) return 0;
    return 1;
}

static size_t group_size(const core *c)
{
    if (!qualifies(c)) return 0;
    const size_t dofs = (size_t)c->blob.counts.dofs, numbers = (size_t)c->blob.counts.muscles + dofs + 2 * dofs +
                                                               (size_t)c->blob.law_states + 4;
    return sizeof(group) + sizeof(real) * (1 + numbers + state_reals(&c->blob) + blob_reals(&c->blob));
}

static const double *plain(const real *numbers)
{
    return (const double *)(const void *)numbers;
}

static real *array_of(const core *c, const array_place *place)
{
    return *(real *const *)(const void *)((const char *)c + place->array);
}

static size_t length_of(const array_lengths *of, const array_place *place)
{
    return *(const size_t *)(const void *)((const char *)of + place->length);
}

static __attribute__((noinline)) void gather(real *to, const double *const from[GROUP], size_t count)
{
    for (size_t k = 0; k < count; k++)
        for (int i = 0; i < GROUP; i++) to[k][i] = from[i][k];
}

static __attribute__((noinline)) void scatter(real *to, const real *from, int lane, size_t count)
{
    double *out = (double *)(void *)to;
    for (size_t k = 0; k < count; k++) out[k] = from[k][lane];
}

/* Copy arrays of the handles to the lanes. */
static void gather_arrays(group *g, const array_lengths *of, const array_place *places, size_t count)
{
    for (const array_place *place = places; place < places + count; place++) {
        const double *from[GROUP];
        for (int i = 0; i < GROUP; i++) from[i] = plain(array_of(g->handle[i], place));
        gather(array_of(&g->lanes, place), from, length_of(of, place));
    }
}

/* Copy arrays of a lane to its handle. */
static void scatter_arrays(group *g, const array_lengths *of, const array_place *places, size_t count, int lane)
{
    for (const array_place *place = places; place < places + count; place++)
        scatter(array_of(g->handle[lane], place), array_of(&g->lanes, place), lane, length_of(of, place));
}

static int are_equal(const int32_t *a, const int32_t *b, size_t count)
{
    int equal = 1;
    for (size_t k = 0; k < count; k++) equal &= a[k] == b[k];
    return equal;
}

/* Return whether the integers of two blobs agree, such as the indices of frames. */
static int is_same_structure(const core *a, const core *b)
{
    int same = a->has_laws == b->has_laws;
#define SAME_COUNT(name, largest) same = same && a->blob.counts.name == b->blob.counts.name;
    BLOB_COUNTS(SAME_COUNT)
#undef SAME_COUNT
#define SAME_int32_t(name, count) same = same && are_equal(a->blob.name, b->blob.name, (size_t)(count));
#define SAME_real(name, count)
#define SAME_FIELD(type, name, per_item, count) SAME_##type(name, per_item * a->blob.counts.count)
    BLOB_FIELDS(SAME_FIELD)
#undef SAME_FIELD
    return same;
}

/* Copy the constants of the handles, and place all arrays. Return 0 if the handles do not fit together. */
static int load_constants(group *g, const array_lengths *of)
{
    core *c = &g->lanes;
    for (int i = 0; i < GROUP; i++)
        if (!qualifies(g->handle[i]) || !is_same_structure(g->handle[0], g->handle[i])) return 0;
    *c = *g->handle[0];
    c->leaving = &g->leaving;
    real *at = (real *)(((uintptr_t)(g + 1) + sizeof(real) - 1) / sizeof(real) * sizeof(real));
#define PLACE(name, length) c->name = at, at += of->name;
    STATE_ARRAYS(PLACE)
#undef PLACE
#define TAKE_int32_t(name, count)
#define TAKE_real(name, count)                                                             \
    {                                                                                      \
        const double *from[GROUP];                                                         \
        for (int i = 0; i < GROUP; i++) from[i] = plain(g->handle[i]->blob.name);          \
        gather(at, from, (size_t)(count));                                                 \
        c->blob.name = at, at += (count);                                                  \
    }
#define TAKE_FIELD(type, name, per_item, count) TAKE_##type(name, per_item * c->blob.counts.count)
    BLOB_FIELDS(TAKE_FIELD)
#undef TAKE_FIELD
    gather_arrays(g, of, CONSTANTS, SIZE(CONSTANTS));
    g->u = at, at += c->blob.counts.muscles;
    g->extra = at, at += c->blob.counts.dofs;
    g->before = at;
    for (int i = 0; i < GROUP; i++) g->blob_numbers[i] = g->handle[i]->blob.mass;
    return 1;
}

static int has_constants(const group *g)
{
    int has = 1;
    for (int i = 0; i < GROUP; i++) has &= g->blob_numbers[i] == g->handle[i]->blob.mass && !g->handle[i]->externals;
    return has;
}

/* Copy q, qd, the states of muscles and the work to `before`. */
static void remember(group *g)
{
    const core *c = &g->lanes;
    const size_t dofs = (size_t)c->blob.counts.dofs, states = (size_t)c->blob.law_states;
    real *at = g->before;
    memcpy(at, c->q, dofs * sizeof(real)), at += dofs;
    memcpy(at, c->qd, dofs * sizeof(real)), at += dofs;
    memcpy(at, c->law_states, states * sizeof(real)), at += states;
    memcpy(at, c->work, 4 * sizeof(real));
}

/* Set a plain handle to the state before the substep. */
static void restore(const group *g, int lane)
{
    core *c = g->handle[lane];
    const size_t dofs = (size_t)c->blob.counts.dofs, states = (size_t)c->blob.law_states;
    const real *at = g->before;
    scatter(c->q, at, lane, dofs), at += dofs;
    scatter(c->qd, at, lane, dofs), at += dofs;
    scatter(c->law_states, at, lane, states), at += states;
    scatter(c->work, at, lane, 4);
}

static void enforce_alone(core *c, truth passes)
{
    group *g = (group *)(void *)c;
    array_lengths lengths, *of = &lengths;
    const int bits = bits_of(passes) & ~g->leaving;
    if (!bits) return;
    find_lengths(&c->blob, of);
    for (int lane = 0; lane < GROUP; lane++) {
        if (!(bits >> lane & 1)) continue;
        scatter_arrays(g, of, LIMITS, SIZE(LIMITS), lane);
        g->handle[lane]->is_factored = c->is_factored;
        alone_enforce_limits(g->handle[lane]);
        const double *qd = plain(g->handle[lane]->qd);
        for (int32_t j = 0; j < c->blob.counts.dofs; j++) c->qd[j][lane] = qd[j];
    }
}

static void step_all_alone(const group *g, const double *const *u, const double *const *extra, double h, int32_t steps,
                           int32_t *answers)
{
    for (int i = 0; i < GROUP; i++) {
        memset(g->handle[i]->work, 0, 4 * sizeof(double));
        answers[i] = alone_finish(g->handle[i], u[i], extra ? extra[i] : NULL, h, steps);
    }
}

static void step_group(void *memory, core *const *handles, const double *const *u, const double *const *extra, double h,
                       int32_t steps, int32_t *answers)
{
    group *g = memory;
    core *c = &g->lanes;
    array_lengths lengths, *of = &lengths;
    memcpy(g->handle, handles, sizeof g->handle);
    find_lengths(&g->handle[0]->blob, of);
    if (!has_constants(g) && !load_constants(g, of)) {
        step_all_alone(g, u, extra, h, steps, answers);
        return;
    }
    gather_arrays(g, of, STARTS, SIZE(STARTS));
    gather(g->u, u, (size_t)c->blob.counts.muscles);
    if (extra) gather(g->extra, extra, of->q);
    memset(c->work, 0, 4 * sizeof(real));
    int32_t left = g->leaving = 0;
    c->is_factored = 0;
    for (; steps > 0 && left != (1 << GROUP) - 1; steps--) {
        remember(g);
        euler_steps(c, g->u, extra ? g->extra : NULL, number(h), 1);
        for (int i = 0; i < GROUP && g->leaving != left; i++) {
            if (!((g->leaving & ~left) >> i & 1)) continue;
            restore(g, i);
            answers[i] = alone_finish(g->handle[i], u[i], extra ? extra[i] : NULL, h, steps);
            left |= 1 << i;
        }
    }
    for (int lane = 0; lane < GROUP; lane++) {
        if (left >> lane & 1) continue;
        scatter_arrays(g, of, RESULTS, SIZE(RESULTS), lane);
        g->handle[lane]->is_factored = 0;
        answers[lane] = 0;
    }
}

const batch_lanes LANES_NAME = {GROUP, LANES_NARROWER, group_size, step_group};

#endif
