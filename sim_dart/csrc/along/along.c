/* The calls of along.h: plain numbers in, changes out. */
#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../along.h"
#include "../state.h"

#include <string.h>

/* e of number.h */
static const double SMALL = 0x1p-332, PER_SMALL = 0x1p332;

struct core_along {
    core *core;
    real *push_wrench;
};

#define LENGTHS(view)                                                                                  \
    const blob_counts *n = &(view)->counts;                                                            \
    const size_t law_states = (size_t)(view)->law_states, law_constants = (size_t)(view)->law_constants; \
    const size_t dofs = (size_t)n->dofs, muscles = (size_t)n->muscles;                                 \
    const size_t points = (size_t)n->points, tasks = (size_t)n->tasks;                                 \
    const size_t surfaces = (size_t)n->surfaces, wraps = (size_t)n->wraps;                             \
    const size_t pulleys = (size_t)n->pulleys;

/* Numbers of the working memory behind a handle. */
static size_t working_length(const blob_view *view)
{
    size_t length = 0;
    LENGTHS(view)
#define ADD_LENGTH(name, numbers) length += numbers;
    STATE_ARRAYS(ADD_LENGTH)
#undef ADD_LENGTH
    return length;
}

/* Numbers of the blob. */
static size_t blob_length(const blob_view *view)
{
    size_t length = 0;
#define ADD_int32_t(count)
#define ADD_real(count) length += (size_t)(count);
#define ADD_FIELD(type, name, per_item, count) ADD_##type(per_item * view->counts.count)
    BLOB_FIELDS(ADD_FIELD)
#undef ADD_FIELD
    return length;
}

size_t core_along_size(const core *plain)
{
    const size_t numbers = working_length(&plain->blob) + blob_length(&plain->blob);
    return sizeof(core_along) + sizeof(core) + (numbers + 9 * (size_t)plain->pushes) * sizeof(real);
}

static real *widen(real *to, const void *plain, size_t count)
{
    const double *from = plain;
    for (size_t k = 0; k < count; k++) to[k] = from[k];
    return to + count;
}

/* The plain handle is made as ours, but for the numbers that its pointers point to. */
static core *copy(const core *plain, void *memory)
{
    core *c = memory;
    LENGTHS(&plain->blob)
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

core_along *core_along_open(const core *plain, void *memory)
{
    core_along *a = memory;
    const size_t pushes = (size_t)plain->pushes;
    real *point = (real *)(void *)(a + 1);
    a->push_wrench = widen(point, plain->push_point, 3 * pushes);
    a->core = copy(plain, widen(a->push_wrench, plain->push_wrench, 6 * pushes));
    core_push(a->core, plain->pushes, plain->push_frame, point, a->push_wrench);
    return a;
}

/* An array, and how many numbers it has. */
static real *array(const core_along *a, enum along_array which, size_t *length)
{
    const core *c = a->core;
    LENGTHS(&c->blob)
    (void)law_constants, (void)points, (void)surfaces, (void)wraps, (void)pulleys;
    const struct {
        real *numbers;
        size_t length;
    } arrays[] = {
        [ALONG_Q] = {c->q, dofs},
        [ALONG_QD] = {c->qd, dofs},
        [ALONG_STATES] = {c->law_states, law_states},
        [ALONG_COMMANDS] = {c->commands, muscles},
        [ALONG_PUSHES] = {a->push_wrench, 6 * (size_t)c->pushes},
        [ALONG_LENGTHS] = {c->lengths, muscles},
        [ALONG_TASKS] = {c->task_values, 3 * tasks},
        [ALONG_TENSIONS] = {c->tensions, muscles},
        [ALONG_WORK] = {c->work, 3},
        [ALONG_ENERGIES] = {c->energies, 3},
        [ALONG_MOMENTA] = {c->momenta, 6},
    };
    *length = arrays[which].length;
    return arrays[which].numbers;
}

void core_along_set(core_along *a, enum along_array which, const double *values, const double *changes)
{
    size_t length;
    real *numbers = array(a, which, &length);
    for (size_t k = 0; k < length; k++) numbers[k] = changing(values[k], SMALL * changes[k]);
}

void core_along_changes(const core_along *a, enum along_array which, double *changes)
{
    size_t length;
    const real *numbers = array(a, which, &length);
    for (size_t k = 0; k < length; k++) changes[k] = PER_SMALL * change_of(numbers[k]);
}

int core_along_move(core_along *a)
{
    return core_move_checked(a->core, a->core->q, a->core->qd);
}

int core_along_start(core_along *a)
{
    return core_start(a->core, a->core->commands);
}

int core_along_drive(core_along *a)
{
    return core_drive(a->core, a->core->qd, a->core->commands);
}

void core_along_energies(core_along *a)
{
    core_energies(a->core, a->core->qd);
}

int core_along_step(core_along *a, double h, int32_t steps)
{
    return core_step(a->core, a->core->commands, NULL, h, steps);
}

int core_along_runge_kutta(core_along *a, double h, int32_t steps)
{
    return core_runge_kutta(a->core, a->core->commands, NULL, h, steps);
}

#include "end.h"
#endif
