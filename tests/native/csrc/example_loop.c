#include "example_loop.h"

#include "example.h"
#include "robot_terms.h"

core *robot;
control_loop *loop;
size_t robot_size, loop_size;

static uint64_t robot_memory[ROBOT_MEMORY / 8], loop_memory[LOOP_MEMORY / 8];

real *robot_part(const char *name)
{
    size_t length;
    return core_array(robot, name, &length);
}

int example_open(void)
{
    size_t length;
    static robot_and_rows own = {NULL, TASK_ROWS, TASKS};
    const control_robot asked = {&own, terms, TASKS ? tasks : NULL, NULL, NULL, NULL};
    robot_size = core_size(BLOB, sizeof BLOB, NULL, 0);
    loop_size = control_loop_size(COORDINATES, MUSCLES, TASKS);
    if (!robot_size || robot_size > sizeof robot_memory || !loop_size || loop_size > sizeof loop_memory)
        return 1;
    robot = own.robot = core_open(BLOB, sizeof BLOB, robot_memory);
    loop = control_loop_open(&asked, COORDINATES, MUSCLES, TASKS, loop_memory);
    for (size_t i = 0; i < sizeof SETTINGS / sizeof *SETTINGS; i++)
        memcpy(control_loop_array(loop, SETTINGS[i].name, &length), SETTINGS[i].values,
               SETTINGS[i].count * sizeof(real));
    control_loop_reset(loop);
    return 0;
}
