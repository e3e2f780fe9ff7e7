/* Bounds of a program over stages, in the interior-point method. A side of a bound is

     y + e - t = bound,   t z = e l = m,   penalty = z + l

   with y = v or -v, the slack t > 0, the violation e > 0 of soft bounds, the multipliers z and l, and the
   complementarity m, which is 0 at the optimum. */
#ifndef CARDSFLOW_STAGE_BOUNDS_H
#define CARDSFLOW_STAGE_BOUNDS_H

#include "stage_state.h"

/* Set t, e, z and l at v, with the complementarity of the gradient and the distances from the bounds. */
void stage_bounds_start(stage_qp *s);

/* Compute `diagonal`, the terms of all bounds in H. */
void stage_bounds_weigh(stage_qp *s);

/* Compute `force`, their terms in the gradient, for the complementarity m. */
void stage_bounds_push(stage_qp *s, real m);

/* Return the largest length up to 2 of the step for m, within all bounds. */
real stage_bounds_reach(stage_qp *s, real m);

/* Return the mean of t z and e l after a step of some length for m, or at v for a length of 0; 0 without
   bounds. With `keep`, store the products of the steps for the corrector. */
real stage_bounds_complementarity(stage_qp *s, real m, real length, int keep);

/* Apply a step of some length for m to t, e, z and l. */
void stage_bounds_apply(stage_qp *s, real m, real length);

#endif
