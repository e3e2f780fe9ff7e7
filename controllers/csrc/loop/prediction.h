/* State and reference after one period, in `later`, `faster` and `ahead`. */
#ifndef CARDSFLOW_PREDICTION_H
#define CARDSFLOW_PREDICTION_H

#include "loop_state.h"

void loop_predict(control_loop *s, real T, const real *q, const real *qd, const real *forces, const real *reference);

#endif
