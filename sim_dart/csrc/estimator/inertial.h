/* Gyroscopes and accelerometers on links. */
#ifndef CARDSFLOW_ESTIMATOR_INERTIAL_H
#define CARDSFLOW_ESTIMATOR_INERTIAL_H

#include "state.h"

/* Process the measurements of all IMUs, at the last q of the core and the current state. */
void estimator_take_inertial(estimator *e);

#endif
