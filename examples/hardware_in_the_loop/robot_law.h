/* The computed-torque law of controllers/csrc for the robot of sim_dart/csrc, in static memory;
 * make_controller.py writes robot.h. The law can be compiled in single precision: see
 * sim_dart/csrc/numbers/real.h. */
#ifndef ROBOT_LAW_H
#define ROBOT_LAW_H

#include "../../controllers/csrc/loop/control_loop.h"
#include "../../sim_dart/csrc/core.h"
#include "robot.h"

#include <math.h>
#include <string.h>

static core *robot;
static control_loop *loop;
static uint64_t robot_memory[ROBOT_MEMORY / 8], loop_memory[LOOP_MEMORY / 8];

static real *part(const char *name)
{
    size_t length;
    return core_array(robot, name, &length);
}

static void terms(void *self, const real *q, const real *qd, real *M, real *h, real *L)
{
    const real *damping = core_coordinates(robot, "damping");
    (void)self;
    core_move(robot, q);
    core_mass_matrix(robot);
    core_bias(robot, qd);
    memcpy(M, part("mass_matrix"), COORDINATES * COORDINATES * sizeof(real));
    memcpy(L, part("jacobian"), MUSCLES * COORDINATES * sizeof(real));
    for (size_t j = 0; j < COORDINATES; j++)
        h[j] = part("coriolis")[j] + damping[j] * qd[j];
}

static void tasks(void *self, const real *q, const real *qd, const real *position, real *error,
                  real *J, real *bias)
{
    (void)self;
    core_move(robot, q);
    core_task_jacobian(robot);
    core_task_bias(robot, qd);
    for (size_t i = 0, count = TASKS; i < count; i++) {
        const size_t row = (size_t)TASK_ROWS[i];
        error[i] = position[i] - part("task_values")[row];
        bias[i] = part("task_bias")[row];
        memcpy(J + i * COORDINATES, part("task_jacobian") + row * COORDINATES,
               COORDINATES * sizeof(real));
    }
}

static void gravity(void *self, const real *q, real *G)
{
    (void)self;
    core_move(robot, q);
    core_gravity(robot);
    memcpy(G, part("gravity"), COORDINATES * sizeof(real));
}

static int open_law(void)
{
    const control_robot asked = {NULL, terms, TASKS ? tasks : NULL, NULL, NULL, gravity};
    size_t length;
    if (core_size(BLOB, sizeof BLOB, NULL, 0) > sizeof robot_memory ||
        control_loop_size(COORDINATES, MUSCLES, TASKS) > sizeof loop_memory)
        return 0;
    robot = core_open(BLOB, sizeof BLOB, robot_memory);
    loop = control_loop_open(&asked, COORDINATES, MUSCLES, TASKS, loop_memory);
    if (!robot || !loop)
        return 0;
    for (size_t i = 0; i < sizeof SETTINGS / sizeof *SETTINGS; i++)
        memcpy(control_loop_array(loop, SETTINGS[i].name, &length), SETTINGS[i].values,
               SETTINGS[i].count * sizeof(real));
    control_loop_reset(loop);
    return 1;
}

/* Compute forces from q and qd, and the reference, all in double precision as in frames; load: known, on the
 * left side of the motion equation. Return an enum computed_torque_status. */
static int tick_law(double period, const double *state, const double *reference, const real *load, double *forces)
{
    real at[2 * COORDINATES], desired[3 * (TASKS ? TASKS : COORDINATES)];
    size_t length;
    for (size_t j = 0; j < sizeof at / sizeof *at; j++)
        at[j] = (real)state[j];
    for (size_t j = 0; j < sizeof desired / sizeof *desired; j++)
        desired[j] = (real)reference[j];
    const int status = control_loop_tick(loop, (real)period, at, at + COORDINATES, desired, load);
    const real *acting = control_loop_array(loop, "acting", &length);
    for (size_t i = 0; i < length; i++)
        forces[i] = (double)acting[i];
    return status;
}

#endif
