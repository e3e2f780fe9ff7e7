/* Computed torque in operational space, eq. (4). */
#ifndef CARDSFLOW_OPERATIONAL_SPACE_H
#define CARDSFLOW_OPERATIONAL_SPACE_H

#include "computed_torque.h"

/* See computed_torque_build, _finish and _solve. */
int operational_space_build(computed_torque *s);
int operational_space_finish(computed_torque *s, const real *x);
int operational_space_solve(computed_torque *s);

#endif
