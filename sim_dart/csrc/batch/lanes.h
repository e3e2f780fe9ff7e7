/* Steps of several instances of a robot at once, one per lane of a vector. Results are bit-identical to those
   of core_step.

   Robots qualify whose paths are straight, without loops, dependent coordinates, joint friction, cable friction and
   external wrenches, and whose muscle laws are in lane_parts.h. */
#ifndef CARDSFLOW_BATCH_LANES_H
#define CARDSFLOW_BATCH_LANES_H

#include "../core.h"

#define LANES_OF_BATCH 4

/* Number of one instance. */
typedef PRECISE(double, float) lane_real;

/* Functions for lanes, for one kind of processor. */
typedef struct {
    /* Return the size of the working memory of a group, or 0 if the robot does not qualify. */
    size_t (*size)(const core *c);
    /* Do the same as core_step for LANES_OF_BATCH handles with the commands u, and the forces `extra`, or NULL. */
    void (*step)(void *memory, core *const *handles, const lane_real *const *u, const lane_real *const *extra, lane_real h,
                 int32_t steps, int32_t *answers);
} batch_lanes;

/* Return the functions for the processor on which a handle was opened; NULL if there are none. */
const batch_lanes *batch_lanes_for(const core *c);

#endif
