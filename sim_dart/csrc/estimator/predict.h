/* Prediction of the state. */
#ifndef CARDSFLOW_ESTIMATOR_PREDICT_H
#define CARDSFLOW_ESTIMATOR_PREDICT_H

#include "state.h"

/* Advance the state and its covariance by h. Return 0, or nonzero if the step of the core fails. */
int estimator_predict(estimator *e, real h);

#endif
