/* Norms of forces other than the 2-norm, in joint space. */
#ifndef CARDSFLOW_NORM_H
#define CARDSFLOW_NORM_H

#include "torque_state.h"

/* Continue from the least-squares forces, with the rows and bounds in s->hard, to the forces of minimum
   p-norm. Return 0, or the status of a program that was not solved; in this case the forces do not change. */
int norm_minimize(computed_torque *s);

#endif
