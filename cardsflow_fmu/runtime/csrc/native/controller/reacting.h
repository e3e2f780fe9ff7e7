/* Reaction of a native controller to lost muscles: forces within the bounds of the muscles, and a decision about
 * the motion; see controllers/csrc/reaction/reaction.h. All functions have no effect without bounds as inputs. */
#ifndef NATIVE_REACTING_H
#define NATIVE_REACTING_H

#include "state.h"

/* Return 0, or nonzero with a message; must be closed in either case. The loop must be open and filled. */
int native_reacting_open(struct controller *c, const struct native_robot *robot, struct text *error);
void native_reacting_close(struct controller *c);
void native_reacting_reset(struct controller *c);

/* Decide, and restrict the forces of the loop to the bounds. Return the reference of the tick. */
const double *native_reacting_set(struct controller *c, const struct native_robot *robot);

/* Restrict limits of all actuators, a, to the bounds of the last call of native_reacting_set. */
void native_reacting_limit(const struct controller *c, double *f_min, double *f_max);

/* Report the status of the law, and write the outputs. */
void native_reacting_finish(struct controller *c, double period, int is_infeasible);

/* Return whether the tasks are released, because the joints are braked. */
int native_reacting_releases_tasks(const struct controller *c);

/* Return the internal state and its length, which may be 0. */
double *native_reacting_memory(const struct controller *c, size_t *length);

#endif
