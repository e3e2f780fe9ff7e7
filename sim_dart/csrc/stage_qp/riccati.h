/* Newton's step of a program over stages, by a recursion of Riccati over the costs to go

     V_k(dx) = 1/2 dx' P_k dx + p_k' dx,   V_k(dx_k) = min over du_k of the cost of stage k + V_k+1(dx_k+1)

   in a time proportional to the number of stages. */
#ifndef CARDSFLOW_RICCATI_H
#define CARDSFLOW_RICCATI_H

#include "stage_state.h"

/* Compute slope = H v + g and the defects of the dynamics at v. */
void riccati_residuals(stage_qp *s);

/* Factorize the system with H + diagonal. Return nonzero if the cost is not convex. */
int riccati_factorize(stage_qp *s);

/* Compute the step of the factorized system, which removes the residuals, with the force of the bounds. */
void riccati_solve(stage_qp *s);

#endif
