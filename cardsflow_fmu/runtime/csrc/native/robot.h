/* A robot of a native FMU, opened in the C core, with the arrays that its models use. */
#ifndef NATIVE_ROBOT_H
#define NATIVE_ROBOT_H

#include "../../../../sim_dart/csrc/core.h"
#include "file.h"

#include <stddef.h>

struct native_robot {
    core *core;
    void *memory;
    size_t n, m, s, tasks, far, bends;
    double *q, *qd, *lengths, *jacobian, *task_values, *task_jacobian, *task_bias;
    double *mass_matrix, *bias, *gravity;
    double *tensions, *states; /* m, number of states: of muscles with muscle laws */
    double *force_low, *force_high, *commands; /* m */
    double *far_tensions; /* m with cable friction, otherwise empty */
    double *pull_jacobian, *slips; /* m x n with cable friction; number of bends, the last states */
    double *work, *energies, *momenta;
    const double *lower, *upper, *damping;
    double *load; /* n: working memory for generalised loads */
};

/* Return 0, or nonzero with a message. */
int native_robot_open(struct native_robot *robot, const struct native_file *file, struct text *error);
void native_robot_close(struct native_robot *robot);

/* Return whether all indices are below `end`. */
int native_all_below(const uint32_t *indices, size_t count, size_t end);
int native_all_finite(const double *values, size_t count);

/* Compute load = sign J' w at the last q, for forces w on rows of the tasks. */
void native_robot_load(struct native_robot *robot, const uint32_t *rows, size_t count, const double *w,
                       double sign);

#endif
