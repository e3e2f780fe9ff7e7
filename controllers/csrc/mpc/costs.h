/* Gauss-Newton approximation of the cost of the planned motion, in the program of its change. */
#ifndef CARDSFLOW_MPC_COSTS_H
#define CARDSFLOW_MPC_COSTS_H

#include "mpc_state.h"

/* Set H and g of the program, from errors and linearized dynamics; correction: of accelerations, r. */
void mpc_set_costs(mpc *s, const real *correction);

#endif
