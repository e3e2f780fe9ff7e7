/* Correction of the state by measurements. */
#ifndef CARDSFLOW_ESTIMATOR_CORRECT_H
#define CARDSFLOW_ESTIMATOR_CORRECT_H

#include "state.h"

/* Begin the measurements of a tick. All of them are linearised about the current state. */
void estimator_begin(estimator *e);

/* Process one scalar measurement z, an element of lengths, encoders, gyroscope or accelerometer: its derivatives
   by the first `width` states, and by a bias with an index below N (N: no bias); its difference from the value
   expected at the current state, which of the filter is the one of estimator_begin; its variance. */
void estimator_take(estimator *e, const real *z, const real *row, size_t width, size_t bias, real residual,
                    real variance);

/* Apply the corrections of all measurements to the state. */
void estimator_end(estimator *e);

#endif
