/* Functions of plain handles, for instances that are computed in lanes. */
#ifndef CARDSFLOW_BATCH_ALONE_H
#define CARDSFLOW_BATCH_ALONE_H

#include "../core.h"

/* Apply the joint limits to qd. */
void alone_enforce_limits(core *c);
/* Move to q without a check, then do further steps of a call of core_step. Return its return value. */
int alone_finish(core *c, const double *u, const double *extra, double h, int32_t steps);

#endif
