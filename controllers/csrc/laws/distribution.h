/* Force distribution: the forces that produce a torque, eq. (3). */
#ifndef CARDSFLOW_DISTRIBUTION_H
#define CARDSFLOW_DISTRIBUTION_H

#include "computed_torque.h"

/* See computed_torque_build, _finish and _solve. */
int distribution_build(computed_torque *s);
int distribution_finish(computed_torque *s, const real *x);
int distribution_solve(computed_torque *s);

#endif
