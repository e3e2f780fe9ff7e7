/* Gyroscopes and accelerometers on links. */
#ifndef CARDSFLOW_ESTIMATOR_INERTIAL_H
#define CARDSFLOW_ESTIMATOR_INERTIAL_H

#include "state.h"

/* Take the measurements of all units, at the core's last q and the state. */
void estimator_take_inertial(estimator *e);

#endif
