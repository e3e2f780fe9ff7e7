/* The calls of along.h: plain numbers in, changes out. */
#include "names.h"

#include "blob.h"

#include "../along.h"
#include "../state.h"

/* e of number.h */
static const double SMALL = 0x1p-332, PER_SMALL = 0x1p332;

struct core_along {
    core *core;
    real *load_point, *load_wrench; /* 3 and 6 each */
    int32_t *load_frame;
};

static size_t loads_size(int32_t loads)
{
    return (size_t)loads * (9 * sizeof(real) + sizeof(int64_t));
}

/* Nothing of a core's working memory is more than twice as large as that of plain numbers. */
size_t core_along_size(const void *blob, size_t plain_size, int32_t loads)
{
    return sizeof(core_along) + loads_size(loads) + along_blob_size(blob) + 2 * plain_size;
}

core_along *core_along_open(const void *blob, int32_t loads, void *memory)
{
    core_along *a = memory;
    const size_t size = along_blob_size(blob), count = (size_t)loads;
    char *wide = (char *)(a + 1) + loads_size(loads);
    memset(a, 0, sizeof *a + loads_size(loads));
    along_blob_widen(blob, wide);
    a->core = core_open(wide, size, wide + size);
    if (!a->core) return NULL;
    a->load_point = (real *)(void *)(a + 1);
    a->load_wrench = a->load_point + 3 * count;
    a->load_frame = (int32_t *)(void *)(a->load_wrench + 6 * count);
    core_push(a->core, loads, a->load_frame, a->load_point, a->load_wrench);
    return a;
}

void core_along_set(core_along *a, const char *array, const double *values, const double *changes)
{
    size_t length;
    real *numbers = core_array(a->core, array, &length);
    for (size_t k = 0; k < length; k++) numbers[k] = changing(values[k], SMALL * changes[k]);
}

void core_along_changes(core_along *a, const char *array, double *changes)
{
    size_t length;
    const real *numbers = core_array(a->core, array, &length);
    for (size_t k = 0; k < length; k++) changes[k] = PER_SMALL * change_of(numbers[k]);
}

void core_along_load(core_along *a, int32_t k, int32_t task, const double force[3], const double change[3])
{
    const blob_view *blob = &a->core->blob;
    a->load_frame[k] = blob->task_frame[task];
    for (int i = 0; i < 3; i++) {
        a->load_point[3 * k + i] = blob->task_position[3 * task + i];
        a->load_wrench[6 * k + i] = changing(force[i], SMALL * change[i]);
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
