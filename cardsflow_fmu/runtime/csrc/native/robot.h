/* A robot of a native FMU, opened in the C core, with what its models take from it. */
#ifndef NATIVE_ROBOT_H
#define NATIVE_ROBOT_H

#include "../../../../sim_dart/csrc/core.h"
#include "file.h"

#include <stddef.h>

/* Settings of every kind of model begin with these:
 *     number of task points p, whose loads are inputs; index of each among the tasks
 *     number of task coordinates k; index of each among all three of every task
 */
struct native_robot {
    core *core;
    void *memory;
    size_t n, m, s, tasks, p, k;
    const double *points, *rows;
    double *q, *qd, *lengths, *jacobian, *task_values, *task_jacobian, *task_bias;
    double *mass_matrix, *bias;
    double *tensions, *states; /* m, s: of muscles with tension laws */
    double *work, *energies, *momenta;
    const double *lower, *upper, *damping;
    double *load; /* generalised, n: room for the models */
};

/* Takes the first settings off the file's. 0, or nonzero with a message. */
int native_robot_open(struct native_robot *robot, struct native_file *file, struct text *error);
void native_robot_close(struct native_robot *robot);

/* load = sign J_p' w at the last q, of forces w on the task points. */
void native_robot_load(struct native_robot *robot, const double *w, double sign);

/* The task coordinates at the last q, k. */
void native_robot_tasks(const struct native_robot *robot, double *y);

#endif
