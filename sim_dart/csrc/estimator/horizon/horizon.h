/* Ticks of a moving horizon, see frames.h. Without a horizon, these functions do nothing. */
#ifndef CARDSFLOW_HORIZON_H
#define CARDSFLOW_HORIZON_H

#include "frames.h"

/* Remember the state before a tick; the first frame is removed if all are used. */
void horizon_begin(estimator *e, real h, int32_t steps);

/* Append the predicted state as a frame. */
void horizon_append(estimator *e);

/* Minimise over all frames; the last one becomes the state. Return an enum estimator_status: diverged if a step of
   the core fails. */
int horizon_solve(estimator *e);

#endif
