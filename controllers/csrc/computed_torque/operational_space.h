/* Computed torque in operational space, eq. (4). */
#ifndef CARDSFLOW_OPERATIONAL_SPACE_H
#define CARDSFLOW_OPERATIONAL_SPACE_H

#include "computed_torque.h"

/* An enum computed_torque_status. */
int operational_space_solve(computed_torque *s);

#endif
