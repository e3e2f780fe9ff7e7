/* The law in joint space that a handle's array `law` chooses. */
#ifndef CARDSFLOW_LAW_CHOICE_H
#define CARDSFLOW_LAW_CHOICE_H

#include "torque_state.h"

/* tau of the law, in s->tau; unchanged if it is given. */
void joint_law_torque(computed_torque *s);

#endif
