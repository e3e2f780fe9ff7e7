/* The calls of along.h: plain numbers in, changes out. */
#include "names.h"

#include "../along.h"
#include "../state.h"

#include <string.h>

/* e of number.h */
static const double SMALL = 0x1p-332, PER_SMALL = 0x1p332;

struct core_along {
    core *core;
    real *push_point, *push_wrench; /* 3 and 6 each */
    int32_t *push_frame;
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

static size_t pushes_size(int32_t pushes)
{
    return (size_t)pushes * (9 * sizeof(real) + sizeof(int64_t));
}

size_t core_along_size(const core *plain, int32_t pushes)
{
    const size_t numbers = working_length(&plain->blob) + blob_length(&plain->blob);
    return sizeof(core_along) + pushes_size(pushes) + sizeof(core) + numbers * sizeof(real);
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

core_along *core_along_open(const core *plain, int32_t pushes, void *memory)
{
    core_along *a = memory;
    const size_t count = (size_t)pushes;
    memset(a, 0, sizeof *a + pushes_size(pushes));
    a->push_point = (real *)(void *)(a + 1);
    a->push_wrench = a->push_point + 3 * count;
    a->push_frame = (int32_t *)(void *)(a->push_wrench + 6 * count);
    a->core = copy(plain, (char *)(a + 1) + pushes_size(pushes));
    core_push(a->core, pushes, a->push_frame, a->push_point, a->push_wrench);
    return a;
}

/* An array, and how many numbers it has. */
static real *array(const core_along *a, enum along_array which, size_t *length)
{
    const core *c = a->core;
    LENGTHS(&c->blob)
    (void)law_constants, (void)points, (void)surfaces, (void)wraps, (void)pulleys;
    real *const arrays[] = {c->q, c->qd, c->law_states, c->commands, c->lengths, c->task_values, c->tensions};
    const size_t lengths[] = {dofs, dofs, law_states, muscles, muscles, 3 * tasks, muscles};
    *length = lengths[which];
    return arrays[which];
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

void core_along_load(core_along *a, int32_t k, int32_t task, const double force[3], const double change[3])
{
    const blob_view *blob = &a->core->blob;
    a->push_frame[k] = blob->task_frame[task];
    for (int i = 0; i < 3; i++) {
        a->push_point[3 * k + i] = blob->task_position[3 * task + i];
        a->push_wrench[6 * k + i] = changing(force[i], SMALL * change[i]);
    }
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

int core_along_step(core_along *a, double h, int32_t steps)
{
    return core_step(a->core, a->core->commands, NULL, h, steps);
}

int core_along_runge_kutta(core_along *a, double h, int32_t steps)
{
    return core_runge_kutta(a->core, a->core->commands, NULL, h, steps);
}

#include "end.h"
