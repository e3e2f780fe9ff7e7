/* Disturbance observer, based on the change of velocity due to the forces of the last tick. */
#ifndef CARDSFLOW_OBSERVER_OF_LOOP_H
#define CARDSFLOW_OBSERVER_OF_LOOP_H

#include "loop_state.h"

void loop_observe(control_loop *s, real period, const real *q, const real *qd);

#endif
