/* Where the state goes within a step. */
#ifndef CARDSFLOW_ESTIMATOR_PREDICT_H
#define CARDSFLOW_ESTIMATOR_PREDICT_H

#include "state.h"

/* The state and its covariance after h; 0, or nonzero where the core's step fails. */
int estimator_predict(estimator *e, real h);

#endif
