/* The law in joint space that the array `law` of a handle selects. */
#ifndef CARDSFLOW_LAW_CHOICE_H
#define CARDSFLOW_LAW_CHOICE_H

#include "torque_state.h"

/* Compute tau of the law in s->tau; a given tau does not change. */
void joint_law_torque(computed_torque *s);

#endif
