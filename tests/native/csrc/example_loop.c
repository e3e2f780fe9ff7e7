#include "example_loop.h"

#include "example.h"

#include <string.h>

core *robot;
control_loop *loop;
size_t robot_size, loop_size;

static uint64_t robot_memory[ROBOT_MEMORY / 8], loop_memory[LOOP_MEMORY / 8];

real *robot_part(const char *name)
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
    memcpy(M, robot_part("mass_matrix"), COORDINATES * COORDINATES * sizeof(real));
    memcpy(L, robot_part("jacobian"), MUSCLES * COORDINATES * sizeof(real));
    for (size_t j = 0; j < COORDINATES; j++) h[j] = robot_part("coriolis")[j] + damping[j] * qd[j];
}

static void tasks(void *self, const real *q, const real *qd, const real *position, real *error,
                  real *J, real *bias)
{
    (void)self;
    core_move(robot, q);
    core_task_jacobian(robot);
    core_task_bias(robot, qd);
    for (size_t i = 0, rows = TASKS; i < rows; i++) {
        const size_t row = (size_t)TASK_ROWS[i];
        error[i] = position[i] - robot_part("task_values")[row];
        bias[i] = robot_part("task_bias")[row];
        memcpy(J + i * COORDINATES, robot_part("task_jacobian") + row * COORDINATES,
               COORDINATES * sizeof(real));
    }
}

/* law.<name> or loop.<name> */
static real *setting(const char *name)
{
    size_t length;
    return name[1] == 'a' ? computed_torque_array(control_loop_law(loop), name + 4, &length)
                          : control_loop_array(loop, name + 5, &length);
}

int example_open(void)
{
    const control_robot asked = {NULL, terms, tasks};
    robot_size = core_size(BLOB, sizeof BLOB, NULL, 0);
    loop_size = control_loop_size(COORDINATES, MUSCLES, TASKS);
    if (!robot_size || robot_size > sizeof robot_memory || !loop_size || loop_size > sizeof loop_memory)
        return 1;
    robot = core_open(BLOB, sizeof BLOB, robot_memory);
    loop = control_loop_open(&asked, COORDINATES, MUSCLES, TASKS, loop_memory);
    for (size_t i = 0; i < sizeof SETTINGS / sizeof *SETTINGS; i++)
        memcpy(setting(SETTINGS[i].name), SETTINGS[i].values, SETTINGS[i].count * sizeof(real));
    control_loop_reset(loop);
    return 0;
}
