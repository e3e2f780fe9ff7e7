/* The controller of an example, whose robot and settings are constant data and whose memory is static.
   `example.h` is written by example.py.                                                                */
#ifndef EXAMPLE_LOOP_H
#define EXAMPLE_LOOP_H

#include "controllers/csrc/loop/control_loop.h"
#include "sim_dart/csrc/core.h"

extern core *robot;
extern control_loop *loop;
extern size_t robot_size, loop_size; /* of the memory, in bytes */

/* 0, or nonzero where the memory is too small. */
int example_open(void);

/* An array of the robot. */
real *robot_part(const char *name);

#endif
