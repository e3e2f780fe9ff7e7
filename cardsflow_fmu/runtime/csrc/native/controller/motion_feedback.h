/* The forces and gains of an optimal motion in a native controller. All functions have no effect without a
 * motion. */
#ifndef NATIVE_MOTION_FEEDBACK_H
#define NATIVE_MOTION_FEEDBACK_H

#include "state.h"

/* Read the motion of the settings, and use it in the loop. Return 0, or nonzero with a message; must be closed
 * in either case. */
int native_motion_open(struct controller *c, const struct native_robot *robot, struct text *error);
void native_motion_close(struct controller *c);

/* Set the time of a tick, whose state is predicted by one period if the loop predicts it. */
void native_motion_set(struct controller *c, double time, double period);

/* Return the commands of all muscles after a tick, m; NULL if the forces determine them. */
const double *native_motion_commands(const struct controller *c);

#endif
