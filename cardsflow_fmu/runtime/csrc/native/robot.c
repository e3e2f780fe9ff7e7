#include "robot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double *array(core *c, const char *name, size_t *length)
{
    return core_array(c, name, length);
}

int native_robot_open(struct native_robot *robot, const struct native_file *file, struct text *error)
{
    char message[256] = "";
    memset(robot, 0, sizeof *robot);
    const size_t size = core_size(file->blob, file->blob_size, message, sizeof message);
    if (!size) {
        text_set(error, "native.bin: %s", message);
        return 1;
    }
    robot->memory = malloc(size);
    if (!robot->memory || !(robot->core = core_open(file->blob, file->blob_size, robot->memory))) {
        text_set(error, "not enough memory for the robot");
        return 1;
    }
    core *c = robot->core;
    size_t length;
    robot->q = array(c, "q", &robot->n);
    robot->qd = array(c, "qd", &length);
    robot->lengths = array(c, "lengths", &robot->m);
    robot->jacobian = array(c, "jacobian", &length);
    robot->task_values = array(c, "task_values", &length);
    robot->tasks = length / 3;
    robot->task_jacobian = array(c, "task_jacobian", &length);
    robot->task_bias = array(c, "task_bias", &length);
    robot->mass_matrix = array(c, "mass_matrix", &length);
    robot->bias = array(c, "coriolis", &length);
    robot->gravity = array(c, "gravity", &length);
    robot->tensions = array(c, "tensions", &length);
    robot->far_tensions = array(c, "far_tensions", &robot->far);
    robot->force_low = array(c, "force_low", &length);
    robot->force_high = array(c, "force_high", &length);
    robot->commands = array(c, "commands", &length);
    robot->pull_jacobian = array(c, "pull_jacobian", &length);
    robot->states = array(c, "law_states", &robot->s);
    array(c, "bend_grip", &robot->bends);
    robot->slips = robot->states + (robot->s - robot->bends);
    robot->work = array(c, "work", &length);
    robot->energies = array(c, "energies", &length);
    robot->momenta = array(c, "momenta", &length);
    robot->lower = core_coordinates(c, "lower");
    robot->upper = core_coordinates(c, "upper");
    robot->damping = core_coordinates(c, "damping");
    robot->load = calloc(robot->n + 1, sizeof *robot->load);
    if (!robot->load)
        text_set(error, "not enough memory for the robot");
    return !robot->load;
}

void native_robot_close(struct native_robot *robot)
{
    free(robot->memory);
    free(robot->load);
}

int native_all_below(const uint32_t *indices, size_t count, size_t end)
{
    for (size_t i = 0; i < count; i++)
        if (indices[i] >= end)
            return 0;
    return 1;
}

int native_all_finite(const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i]))
            return 0;
    return 1;
}

void native_robot_load(struct native_robot *robot, const uint32_t *rows, size_t count, const double *w,
                       double sign)
{
    core_task_jacobian(robot->core);
    memset(robot->load, 0, robot->n * sizeof *robot->load);
    for (size_t i = 0; i < count; i++) {
        const double force = sign * w[i], *row = robot->task_jacobian + rows[i] * robot->n;
        for (size_t j = 0; j < robot->n; j++)
            robot->load[j] += force * row[j];
    }
}
