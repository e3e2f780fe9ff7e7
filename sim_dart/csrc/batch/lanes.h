/* Steps of several instances of a robot at once, one per lane of a vector. Results are bit-identical to those
   of core_step.

   Robots qualify whose paths are straight, without loops, dependent coordinates, joint friction, soft limits, cable friction and
   external wrenches, and whose muscle laws are in lane_parts.h. */
#ifndef CARDSFLOW_BATCH_LANES_H
#define CARDSFLOW_BATCH_LANES_H

#include "../core.h"

#define MAX_LANES 8

/* Number of one instance. */
typedef PRECISE(double, float) lane_real;

/* Functions for lanes, for one kind of processor. */
typedef struct batch_lanes batch_lanes;
struct batch_lanes {
    int32_t count;               /* number of lanes */
    const batch_lanes *narrower; /* functions for fewer lanes, or NULL */
    /* Return the size of the working memory of a group, or 0 if the robot does not qualify. */
    size_t (*size)(const core *c);
    /* Do the same as core_step for `count` handles with the commands u, and the forces `extra`, or NULL. */
    void (*step)(void *memory, core *const *handles, const lane_real *const *u, const lane_real *const *extra, lane_real h,
                 int32_t steps, int32_t *answers);
};

/* Those of lanes.c, lanes_wide.c and lanes_widest.c, where they exist. */
extern const batch_lanes BATCH_LANES, BATCH_LANES_WIDE, BATCH_LANES_WIDEST;

/* Return the functions with most lanes for the processor on which a handle was opened; NULL if there are none. */
const batch_lanes *batch_lanes_for(const core *c);

#endif
