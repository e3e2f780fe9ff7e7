/* The controller of an example, with robot and settings as constant data and with static memory. example.py
   writes `example.h`. */
#ifndef EXAMPLE_LOOP_H
#define EXAMPLE_LOOP_H

#include "controllers/csrc/loop/control_loop.h"
#include "sim_dart/csrc/core.h"

extern core *robot;
extern control_loop *loop;
extern size_t robot_size, loop_size; /* size of the memory, in bytes */

/* Return 0, or nonzero if the memory is too small. */
int example_open(void);

/* Return an array of the robot. */
real *robot_part(const char *name);

#endif
