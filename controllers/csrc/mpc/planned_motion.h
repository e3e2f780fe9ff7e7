/* The motion from which a tick starts: the last one, shifted by a period. */
#ifndef CARDSFLOW_PLANNED_MOTION_H
#define CARDSFLOW_PLANNED_MOTION_H

#include "mpc_state.h"

/* Set the lengths of the intervals. */
void planned_motion_divide(mpc *s);

/* Start with a robot at rest and the preferred forces. */
void planned_motion_rest(mpc *s, const real *q);

/* Shift the last motion by a period, between its nodes. */
void planned_motion_shift(mpc *s);

/* Move the forces into their bounds, which may have changed. */
void planned_motion_clip(mpc *s);

/* Add the solution of the program. */
void planned_motion_add(mpc *s);

#endif
