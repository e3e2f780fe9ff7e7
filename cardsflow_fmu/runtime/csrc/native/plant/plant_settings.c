/* The settings of a native plant, after those of the robot: steps of the integrator in one of the plant; the
 * muscles that take commands, whose tensions are outputs, and which of all muscles' states each output is: of
 * each a number, then the indices; the integrator's rule, 0 Euler's, 1 Runge and Kutta's; whether energies
 * and momenta are outputs; potential energy in J of what does not move; the points of external wrenches, first those that take
 * loads, then those that take wrenches: their number, then of each its frame, or -1 for the world, and its
 * x, y, z there in m. */
#include "plant_settings.h"

#include <math.h>
#include <stdlib.h>

static int is_whole(double value, double first, double last)
{
    return value >= first && value <= last && value == floor(value);
}

static int has_friction(const struct native_robot *robot)
{
    const double *friction = core_coordinates(robot->core, "friction");
    for (size_t j = 0; j < robot->n; j++)
        if (friction[j] != 0)
            return 1;
    return 0;
}

static int take_rule(struct plant *plant, const struct native_robot *robot, struct native_file *file)
{
    const double *options = native_file_take(file, 3);
    if (!options || !is_whole(options[0], 0, 1) || !is_whole(options[1], 0, 1) || !isfinite(options[2]))
        return 1;
    if (options[0] != 0 && has_friction(robot))
        return 1; /* of which Runge and Kutta know nothing */
    plant->rule = options[0] != 0 ? core_runge_kutta : core_step;
    plant->energy_count = options[1] != 0 ? ENERGY_OUTPUTS : 0;
    plant->standing = options[2];
    return 0;
}

/* The core reads these arrays from now on, in every step. */
static int take_points(struct plant *plant, const struct native_robot *robot, struct native_file *file)
{
    const double *number = native_file_take(file, 1);
    if (!number || !is_whole(number[0], (double)robot->p, (double)(file->settings_count / 4)))
        return 1;
    const size_t count = (size_t)number[0];
    const double *frames = native_file_take(file, count), *points = native_file_take(file, 3 * count);
    plant->k = count - robot->p;
    plant->frames = calloc(count + 1, sizeof *plant->frames);
    plant->external_wrenches = calloc(6 * count + 1, sizeof *plant->external_wrenches);
    if (!plant->frames || !plant->external_wrenches)
        return 1;
    for (size_t i = 0; i < 3 * count; i++)
        if (!isfinite(points[i]))
            return 1;
    for (size_t i = 0; i < count; i++) {
        if (!is_whole(frames[i], -1, (double)robot->n - 1))
            return 1;
        plant->frames[i] = (int32_t)frames[i];
    }
    return core_external_wrenches(robot->core, (int32_t)count, plant->frames, points, plant->external_wrenches);
}

static int take(struct plant *plant, const struct native_robot *robot, struct native_file *file)
{
    const double *substeps = native_file_take(file, 1);
    if (!substeps || !is_whole(substeps[0], 1, 1e6))
        return 1;
    plant->substeps = substeps[0];
    return native_file_take_indices(file, robot->m, &plant->c, &plant->commanded) ||
           native_file_take_indices(file, robot->m, &plant->t, &plant->modelled) ||
           native_file_take_indices(file, robot->s, &plant->s, &plant->order) || take_rule(plant, robot, file) ||
           take_points(plant, robot, file) || file->settings_count;
}

int native_plant_settings(struct plant *plant, struct native_model *native, struct text *error)
{
    plant->muscle_commands = calloc(native->robot.m + 1, sizeof *plant->muscle_commands);
    if (plant->muscle_commands && !take(plant, &native->robot, &native->file))
        return 0;
    text_set(error, plant->muscle_commands ? "native.bin does not fit its plant" : "there is no memory for the model");
    return 1;
}

int native_plant_place(struct plant *plant, const struct native_model *native, struct text *error)
{
    const struct native_robot *robot = &native->robot;
    const struct {
        double **row;
        size_t length;
    } rows[] = {
        {&plant->commands, plant->c},
        {&plant->loads, 3 * robot->p},
        {&plant->wrenches, 6 * plant->k},
        {&plant->q, robot->n},
        {&plant->qd, robot->n},
        {&plant->lengths, robot->m},
        {&plant->tasks, robot->k},
        {&plant->tensions, plant->t},
        {&plant->states, plant->s},
        {&plant->energies, plant->energy_count},
        {&plant->q_start, robot->n},
        {&plant->qd_start, robot->n},
        {&plant->step, 2}, /* behind it the worker's timeout */
    };
    const size_t count = sizeof rows / sizeof *rows;
    size_t total = 0;
    for (size_t i = 0; i < count; i++)
        total += rows[i].length;
    if (!native_has_values(native, total, error))
        return 1;
    double *at = native->values;
    for (size_t i = 0; i < count; at += rows[i++].length)
        *rows[i].row = at;
    return 0;
}

void native_plant_free(struct plant *plant)
{
    if (!plant)
        return;
    free(plant->muscle_commands);
    free(plant->frames);
    free(plant->external_wrenches);
    free(plant->tangent);
    free(plant);
}
