/* Opening a blob: nothing in it is trusted. */
#include "law.h"
#include "message.h"
#include "state.h"

#include <math.h>

#define LAYOUT_COUNT(name, largest) "count " #name "\n"
#define PARAMETER_NAME(name) " " #name
#define LAYOUT_LAW(kind, law, parameters) "law " #kind parameters(PARAMETER_NAME) "\n"
#define LAYOUT_FIELD(type, name, per_item, count) #type " " #name " " #per_item " " #count "\n"

const char *core_layout(void)
{
    return BLOB_COUNTS(LAYOUT_COUNT) BLOB_FIELDS(LAYOUT_FIELD) LAWS(LAYOUT_LAW);
}

/* FNV-1a */
uint32_t core_layout_hash(void)
{
    uint32_t hash = 2166136261u;
    for (const char *p = core_layout(); *p; p++) hash = (hash ^ (unsigned char)*p) * 16777619u;
    return hash;
}

uint32_t core_version(void)
{
    return BLOB_VERSION;
}

int refuse(char *message, size_t capacity, const char *format, ...)
{
    if (message && capacity) {
        va_list arguments;
        va_start(arguments, format);
        message_write(message, capacity, format, arguments);
        va_end(arguments);
    }
    return 1;
}

static size_t padded(size_t bytes)
{
    return (bytes + 7u) & ~(size_t)7u;
}

static size_t expected_size(const blob_counts *n)
{
    size_t size = sizeof(blob_header);
#define ADD_SIZE(type, name, per_item, count) size += padded(sizeof(type) * per_item * (size_t)n->count);
    BLOB_FIELDS(ADD_SIZE)
#undef ADD_SIZE
    return size;
}

static int check_header(const blob_header *h, size_t size, char *message, size_t capacity)
{
    if (h->magic == PRECISE(BLOB_MAGIC_FLOAT, BLOB_MAGIC_DOUBLE))
        return refuse(message, capacity, "the blob's numbers are of " PRECISE("single", "double")
                      " precision, those of this library of " PRECISE("double", "single"));
    if (h->magic != BLOB_MAGIC) return refuse(message, capacity, "this is not a robot blob");
    if (h->version != BLOB_VERSION || h->layout_hash != core_layout_hash())
        return refuse(message, capacity, "the blob has version %u, this library reads version %u",
                      (unsigned)h->version, BLOB_VERSION);
#define CHECK_COUNT(name, largest)                                                                     \
    if (h->counts.name < 0 || h->counts.name > largest)                                                \
        return refuse(message, capacity, "number of " #name " %d is not within 0 to %d",               \
                      (int)h->counts.name, largest);
    BLOB_COUNTS(CHECK_COUNT)
#undef CHECK_COUNT
    if (h->size != size || expected_size(&h->counts) != size)
        return refuse(message, capacity, "the blob has %zu bytes, its header promises %zu", size,
                      expected_size(&h->counts));
    return 0;
}

static void set_pointers(blob_view *view, const blob_header *h)
{
    const char *at = (const char *)(h + 1);
    view->counts = h->counts;
#define SET_POINTER(type, name, per_item, count)                                                       \
    view->name = (const type *)(const void *)at;                                                       \
    at += padded(sizeof(type) * per_item * (size_t)h->counts.count);
    BLOB_FIELDS(SET_POINTER)
#undef SET_POINTER
}

static int all_finite(const real *values, size_t count)
{
    for (size_t k = 0; k < count; k++)
        if (!isfinite(values[k])) return 0;
    return 1;
}

static int is_rotation(const real R[9])
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k <= i; k++)
            if (!(fabs(dot3(R + 3 * i, R + 3 * k) - (i == k)) < UNIT_TOLERANCE)) return 0;
    return 1;
}

/* Every frame is driven by a coordinate of its own. Quadratic, but only once, and without memory. */
static int check_coordinates(const blob_view *b, char *message, size_t capacity)
{
    for (int i = 0; i < b->counts.dofs; i++) {
        if (b->coordinate[i] < 0 || b->coordinate[i] >= b->counts.dofs)
            return refuse(message, capacity, "frame %d: there is no coordinate %d", i,
                          (int)b->coordinate[i]);
        for (int k = 0; k < i; k++)
            if (b->coordinate[k] == b->coordinate[i])
                return refuse(message, capacity, "frames %d and %d share coordinate %d", k, i,
                              (int)b->coordinate[i]);
    }
    return 0;
}

/* Inertias that are no bodies' make a mass matrix that is not positive definite: the caller's check. */
static int check_masses(const blob_view *b, char *message, size_t capacity)
{
    for (int i = 0; i < b->counts.dofs; i++) {
        if (!(b->mass[i] >= 0) || !all_finite(b->mass + i, 1))
            return refuse(message, capacity, "frame %d: its mass is not from 0 on", i);
        if (!all_finite(b->mass_centre + 3 * i, 3) || !all_finite(b->inertia + 6 * i, 6))
            return refuse(message, capacity, "frame %d: its inertia is not finite", i);
        if (!(b->damping[i] >= 0) || !all_finite(b->damping + i, 1))
            return refuse(message, capacity, "coordinate %d: its damping is not from 0 on", i);
        if (!(b->friction[i] >= 0) || !all_finite(b->friction + i, 1))
            return refuse(message, capacity, "coordinate %d: its friction is not from 0 on", i);
        if (!(b->stiffness[i] >= 0) || !all_finite(b->stiffness + i, 1) || !all_finite(b->rest + i, 1))
            return refuse(message, capacity, "coordinate %d: its spring is not from 0 on, or not finite", i);
        if (!(b->lower[i] <= b->upper[i]))
            return refuse(message, capacity, "coordinate %d: its limits are no interval", i);
    }
    if (b->counts.robots != 1 || !all_finite(b->gravity, 3))
        return refuse(message, capacity, "there is no finite gravity");
    return 0;
}

static int check_frames(const blob_view *b, char *message, size_t capacity)
{
    for (int i = 0; i < b->counts.dofs; i++) {
        if (b->parent[i] < -1 || b->parent[i] >= i)
            return refuse(message, capacity, "frame %d: parent %d does not come before it", i,
                          (int)b->parent[i]);
        if (b->motion[i] < 0 || b->motion[i] >= MOTIONS)
            return refuse(message, capacity, "frame %d: unknown motion %d", i, (int)b->motion[i]);
        if (!is_rotation(b->offset_rotation + 9 * i))
            return refuse(message, capacity, "frame %d: its rotation is not orthonormal", i);
        if (!all_finite(b->offset_position + 3 * i, 3))
            return refuse(message, capacity, "frame %d: its position is not finite", i);
        const real *a = b->axis + 3 * i;
        if (!(fabs(dot3(a, a) - 1) < UNIT_TOLERANCE))
            return refuse(message, capacity, "frame %d: its axis is no unit vector", i);
    }
    return 0;
}

int check_points(const char *what, const int32_t *frame, const real *position, int32_t points,
                 int32_t dofs, char *message, size_t capacity)
{
    for (int32_t k = 0; k < points; k++) {
        if (frame[k] < -1 || frame[k] >= dofs)
            return refuse(message, capacity, "%s %d: there is no frame %d", what, (int)k, (int)frame[k]);
        if (!all_finite(position + 3 * k, 3))
            return refuse(message, capacity, "%s %d: its position is not finite", what, (int)k);
    }
    return 0;
}

static int check_tasks(const blob_view *b, char *message, size_t capacity)
{
    for (int k = 0; k < b->counts.tasks; k++) {
        if (b->task_kind[k] < 0 || b->task_kind[k] >= TASKS)
            return refuse(message, capacity, "task %d: unknown kind %d", k, (int)b->task_kind[k]);
        if (!is_rotation(b->task_rotation + 9 * k))
            return refuse(message, capacity, "task %d: its rotation is not orthonormal", k);
    }
    return check_points("task", b->task_frame, b->task_position, b->counts.tasks, b->counts.dofs, message,
                        capacity);
}

static int check_muscles(const blob_view *b, char *message, size_t capacity)
{
    int64_t points = 0;
    for (int k = 0; k < b->counts.muscles; k++) {
        if (b->muscle_points[k] < 2) return refuse(message, capacity, "muscle %d: fewer than 2 points", k);
        points += b->muscle_points[k];
    }
    if (points != b->counts.points)
        return refuse(message, capacity, "the muscles' points do not add up to %d", (int)b->counts.points);
    return 0;
}

int blob_open(blob_view *view, const void *blob, size_t size, char *message, size_t capacity)
{
    if (!blob || size < sizeof(blob_header)) return refuse(message, capacity, "the blob is too short");
    if ((uintptr_t)blob % 8) return refuse(message, capacity, "the blob is not 8-byte aligned");
    if (check_header(blob, size, message, capacity)) return 1;
    set_pointers(view, blob);
    const blob_counts *n = &view->counts;
    return check_frames(view, message, capacity) || check_coordinates(view, message, capacity) ||
           check_masses(view, message, capacity) || check_muscles(view, message, capacity) ||
           check_points("via point", view->point_frame, view->point_position, n->points, n->dofs, message,
                        capacity) ||
           check_tasks(view, message, capacity) || paths_check(view, message, capacity) ||
           laws_check(view, message, capacity);
}
