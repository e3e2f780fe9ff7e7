/* Variables: the coordinates q and the dependent variables, x = phi(q). The rates are x' = Gamma qd. The
   tree is computed in x; forces on x become forces on q by Gamma'. These functions apply only to robots with
   `is_driven`; in all other robots every variable is a q. */
#ifndef CARDSFLOW_VARIABLES_H
#define CARDSFLOW_VARIABLES_H

#include "../blob/state.h"

/* Compute the dependent variables in `at` from q, and the slopes. */
CORE_INSIDE void variables_move(core *c);
/* Compute Gamma qd in `moved`, after the last move; also `bend` of x'' = Gamma qdd + bend. */
CORE_INSIDE const real *variables_rates(core *c, const real *qd);
/* Compute rates = Gamma qd. */
CORE_INSIDE void variables_follow(const core *c, const real *qd, real *rates);
/* Compute reduced = Gamma' row; `row` must not be `reduced`, and is overwritten. */
CORE_INSIDE void variables_fold(const core *c, real *row, real *reduced);
/* Compute reduced = Gamma' wide_matrix Gamma; wide_matrix is overwritten. */
CORE_INSIDE void variables_fold_matrix(core *c, real *reduced);

#endif
