#include "check_robot.h"

#include "../../math/vectors.h"
#include "../../numbers/real_functions.h"
#include "check_points.h"
#include "check_variables.h"
#include "../message.h"

#include <math.h>

static int is_rotation(const real R[9])
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k <= i; k++)
            if (!(fabs(dot3(R + 3 * i, R + 3 * k) - (i == k)) < UNIT_TOLERANCE)) return 0;
    return 1;
}

/* Check that each frame has a different variable. The cost is quadratic, but the check runs only once and
   needs no memory. */
static int check_coordinates(const blob_view *b, char *message, size_t capacity)
{
    for (int i = 0; i < b->counts.frames; i++) {
        if (b->coordinate[i] < 0 || b->coordinate[i] >= b->counts.variables)
            return reject(message, capacity, "frame %d: unknown coordinate %d", i,
                          (int)b->coordinate[i]);
        for (int k = 0; k < i; k++)
            if (b->coordinate[k] == b->coordinate[i])
                return reject(message, capacity, "frames %d and %d share coordinate %d", k, i,
                              (int)b->coordinate[i]);
    }
    return 0;
}

/* Check the ranges of masses and forces. An inertia that is not physical results in a mass matrix that is
   not positive definite; the caller checks this. */
static int check_masses(const blob_view *b, char *message, size_t capacity)
{
    for (int i = 0; i < b->counts.frames; i++) {
        if (!(b->mass[i] >= 0) || !all_finite(b->mass + i, 1))
            return reject(message, capacity, "frame %d: its mass must be >= 0", i);
        const real *com = b->mass_centre + 3 * i, about_origin = b->mass[i] * dot3(com, com);
        if (!all_finite(&about_origin, 1) || !all_finite(b->inertia + 6 * i, 6))
            return reject(message, capacity, "frame %d: its inertia is not finite", i);
    }
    for (int i = 0; i < b->counts.variables; i++) {
        if (!(b->damping[i] >= 0) || !all_finite(b->damping + i, 1))
            return reject(message, capacity, "coordinate %d: its damping must be >= 0", i);
        if (!(b->stiffness[i] >= 0) || !all_finite(b->stiffness + i, 1) || !all_finite(b->rest + i, 1))
            return reject(message, capacity, "coordinate %d: its spring must be >= 0 and finite", i);
        if (!(b->armature[i] >= 0) || !all_finite(b->armature + i, 1))
            return reject(message, capacity, "coordinate %d: its armature must be >= 0", i);
    }
    for (int i = 0; i < b->counts.dofs; i++) {
        if (!(b->friction[i] >= 0) || !all_finite(b->friction + i, 1))
            return reject(message, capacity, "coordinate %d: its friction must be >= 0", i);
        if (!(b->lower[i] <= b->upper[i]))
            return reject(message, capacity, "coordinate %d: its limits are not an interval", i);
    }
    if (b->counts.robots != 1 || !all_finite(b->gravity, 3))
        return reject(message, capacity, "gravity is not finite");
    return 0;
}

static int check_frames(const blob_view *b, char *message, size_t capacity)
{
    for (int i = 0; i < b->counts.frames; i++) {
        if (b->parent[i] < -1 || b->parent[i] >= i)
            return reject(message, capacity, "frame %d: parent %d does not come before it", i,
                          (int)b->parent[i]);
        if (b->motion[i] < 0 || b->motion[i] >= MOTIONS)
            return reject(message, capacity, "frame %d: unknown motion %d", i, (int)b->motion[i]);
        if (!is_rotation(b->offset_rotation + 9 * i))
            return reject(message, capacity, "frame %d: its rotation is not orthonormal", i);
        if (!all_finite(b->offset_position + 3 * i, 3))
            return reject(message, capacity, "frame %d: its position is not finite", i);
        const real *a = b->axis + 3 * i;
        if (!(fabs(dot3(a, a) - 1) < UNIT_TOLERANCE))
            return reject(message, capacity, "frame %d: its axis is not a unit vector", i);
    }
    return 0;
}

static int check_closures(const blob_view *b, char *message, size_t capacity)
{
    for (int k = 0; k < b->counts.closures; k++) {
        if (b->closure_kind[k] < 0 || b->closure_kind[k] >= CLOSURES)
            return reject(message, capacity, "closure %d: unknown kind %d", k, (int)b->closure_kind[k]);
        for (int side = 0; side < 2; side++)
            if (b->closure_frame[2 * k + side] < -1 || b->closure_frame[2 * k + side] >= b->counts.frames)
                return reject(message, capacity, "closure %d: unknown frame %d", k,
                              (int)b->closure_frame[2 * k + side]);
        const real *u = b->closure_along + 3 * k, *v = b->closure_other + 3 * k;
        if (!(fabs(dot3(u, u) - 1) < UNIT_TOLERANCE) ||
            (b->closure_kind[k] == CLOSURE_DIRECTION && !(fabs(dot3(v, v) - 1) < UNIT_TOLERANCE)))
            return reject(message, capacity, "closure %d: its direction is not a unit vector", k);
        if (!all_finite(b->closure_at + 3 * k, 3) || !all_finite(v, 3))
            return reject(message, capacity, "closure %d: its position is not finite", k);
    }
    return 0;
}

static int check_tasks(const blob_view *b, char *message, size_t capacity)
{
    for (int k = 0; k < b->counts.tasks; k++) {
        if (b->task_kind[k] < 0 || b->task_kind[k] >= TASKS)
            return reject(message, capacity, "task %d: unknown kind %d", k, (int)b->task_kind[k]);
        if (!is_rotation(b->task_rotation + 9 * k))
            return reject(message, capacity, "task %d: its rotation is not orthonormal", k);
    }
    return check_points("task", b->task_frame, b->task_position, b->counts.tasks, b->counts.frames, message,
                        capacity);
}

static int check_muscles(const blob_view *b, char *message, size_t capacity)
{
    int64_t points = 0;
    for (int k = 0; k < b->counts.muscles; k++) {
        if (b->muscle_points[k] < 0 || b->muscle_points[k] == 1)
            return reject(message, capacity, "muscle %d: fewer than 2 points", k);
        points += b->muscle_points[k];
    }
    if (points != b->counts.points)
        return reject(message, capacity, "the via points do not add up to %d", (int)b->counts.points);
    return 0;
}

int check_robot(const blob_view *b, char *message, size_t capacity)
{
    return check_variables(b, message, capacity) || check_frames(b, message, capacity) ||
            check_coordinates(b, message, capacity) ||
           check_masses(b, message, capacity) || check_muscles(b, message, capacity) ||
           check_points("via point", b->point_frame, b->point_position, b->counts.points, b->counts.frames,
                        message, capacity) ||
           check_closures(b, message, capacity) || check_tasks(b, message, capacity);
}
