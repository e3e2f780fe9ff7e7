/* Computed torque in joint space, eq. (3). */
#ifndef CARDSFLOW_JOINT_SPACE_H
#define CARDSFLOW_JOINT_SPACE_H

#include "computed_torque.h"

/* An enum computed_torque_status. */
int joint_space_solve(computed_torque *s);

#endif
