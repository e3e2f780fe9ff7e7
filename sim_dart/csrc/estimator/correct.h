/* What measurements make of the state. */
#ifndef CARDSFLOW_ESTIMATOR_CORRECT_H
#define CARDSFLOW_ESTIMATOR_CORRECT_H

#include "state.h"

/* Begin a tick's measurements. All are linear about the state as it is now. */
void estimator_begin(estimator *e);

/* One number: its derivatives by the first `width` states, and by a bias, whose index is below N, or N; what it
   differs by from what the state of estimator_begin lets expect; its variance.                              */
void estimator_correct(estimator *e, const real *row, size_t width, size_t bias, real residual, real variance);

/* Take over what they have changed. */
void estimator_end(estimator *e);

#endif
