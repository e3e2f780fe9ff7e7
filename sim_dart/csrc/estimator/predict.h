/* Prediction of the state. */
#ifndef CARDSFLOW_ESTIMATOR_PREDICT_H
#define CARDSFLOW_ESTIMATOR_PREDICT_H

#include "state.h"

/* Advance the state by h, and compute `transition`. Return 0, or nonzero if the step of the core fails. */
int estimator_advance(estimator *e, real h);

/* Compute P <- A P A'. A contains the rows of q and qd, 2 n x 3 n; the others are those of the identity. */
void estimator_propagate(const estimator *e, const real *A, real *P);

/* Add white noise of accelerations, constant within the step h, of dw/dt and of the rates of the biases to P; and
   of impacts at bounds of a horizon. */
void estimator_add_noise(const estimator *e, real h, real *P);

/* Advance the state and its covariance by h. Return 0, or nonzero if the step of the core fails. */
int estimator_predict(estimator *e, real h);

#endif
