/* Measurements of a tick. */
#ifndef CARDSFLOW_ESTIMATOR_MEASUREMENTS_H
#define CARDSFLOW_ESTIMATOR_MEASUREMENTS_H

#include "state.h"

/* Process all measurements, linearised about the current state, at which the core must be. */
void estimator_take_all(estimator *e);

#endif
