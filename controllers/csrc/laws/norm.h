/* Norms of forces other than the second, in joint space. */
#ifndef CARDSFLOW_NORM_H
#define CARDSFLOW_NORM_H

#include "torque_state.h"

/* From the forces of least squares, with the rows and bounds in s->hard, to those of least p-norm. 0, or the
   status of a program that was not solved: the forces stay those of least squares.                    */
int norm_least(computed_torque *s);

#endif
