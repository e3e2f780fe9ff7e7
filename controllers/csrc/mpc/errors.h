/* Errors of the planned motion at its nodes, and their Jacobians. */
#ifndef CARDSFLOW_MPC_ERRORS_H
#define CARDSFLOW_MPC_ERRORS_H

#include "mpc_state.h"

/* Compute error, rate and J of the followed coordinates, and `null` of tasks; `now` is the reference of the
   tick. */
void mpc_compute_errors(mpc *s, const real *now);

#endif
