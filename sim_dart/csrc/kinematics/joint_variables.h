/* Variables: the coordinates q and what follows them, x = phi(q). With p' = Gamma u the tree runs in x, and
   forces on x are Gamma' times as much on q. All of this is for robots that are driven (`is_driven`) only:
   in robots that are not, all variables are q.                                                                     */
#ifndef CARDSFLOW_VARIABLES_H
#define CARDSFLOW_VARIABLES_H

#include "../blob/state.h"

/* The rest of `at` where q is there, and the slopes. */
CORE_INSIDE void variables_move(core *c);
/* Gamma qd, into `moved`, after the last move; also `bend`: x'' = Gamma qdd + bend. */
CORE_INSIDE const real *variables_rates(core *c, const real *qd);
/* rates = Gamma qd. */
CORE_INSIDE void variables_follow(const core *c, const real *qd, real *rates);
/* own = Gamma' row, where `row` is not `own` itself; it is spent. */
CORE_INSIDE void variables_fold(const core *c, real *row, real *own);
/* own = Gamma' wide_matrix Gamma, which is spent. */
CORE_INSIDE void variables_fold_matrix(core *c, real *own);

#endif
