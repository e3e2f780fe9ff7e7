/* Functions of a robot for a control loop, by its core: `terms` and `tasks` of a control_robot. */
#ifndef ROBOT_TERMS_H
#define ROBOT_TERMS_H

#include "controllers/csrc/loop/control_loop.h"
#include "sim_dart/csrc/core.h"

#include <string.h>

typedef struct {
    core *robot;
    const real *rows; /* of the controlled task coordinates */
    size_t count;
} robot_and_rows;

static void copy_part(core *robot, const char *name, real *to)
{
    size_t length;
    const real *from = core_array(robot, name, &length);
    memcpy(to, from, length * sizeof(real));
}

static void terms(void *self, const real *q, const real *qd, real *M, real *h, real *L)
{
    core *robot = ((robot_and_rows *)self)->robot;
    const real *damping = core_coordinates(robot, "damping");
    size_t n;
    core_move(robot, q);
    core_mass_matrix(robot);
    core_bias(robot, qd);
    copy_part(robot, "mass_matrix", M);
    copy_part(robot, "jacobian", L);
    const real *coriolis = core_array(robot, "coriolis", &n);
    for (size_t j = 0; j < n; j++) h[j] = coriolis[j] + damping[j] * qd[j];
}

static void tasks(void *self, const real *q, const real *qd, const real *position, real *error,
                  real *J, real *bias)
{
    const robot_and_rows *own = self;
    size_t length, n;
    core_move(own->robot, q);
    core_task_jacobian(own->robot);
    core_task_bias(own->robot, qd);
    const real *values = core_array(own->robot, "task_values", &length);
    const real *rates = core_array(own->robot, "task_bias", &length);
    const real *jacobian = core_array(own->robot, "task_jacobian", &length);
    core_array(own->robot, "q", &n);
    for (size_t i = 0; i < own->count; i++) {
        const size_t row = (size_t)own->rows[i];
        error[i] = position[i] - values[row];
        bias[i] = rates[row];
        memcpy(J + i * n, jacobian + row * n, n * sizeof(real));
    }
}

#endif
