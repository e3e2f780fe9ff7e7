/* The constraint forces of loop joints. */
#ifndef CARDSFLOW_LOOPS_H
#define CARDSFLOW_LOOPS_H

#include "../blob/state.h"

/* Factorise J M^-1 J' at the last q, with the last factorisation of M. */
CORE_INSIDE void loops_factor(core *c);
/* Compute rates += M^-1 J' p, so that J rates = goal; NULL for zero. Call loops_factor first. */
CORE_INSIDE void loops_project(core *c, const real *goal, real *rates);
/* Compute the change of velocities due to an impulse: M^-1 impulse, projected on the motions that loops
   allow. */
CORE_INSIDE void loops_respond(core *c, const real *impulse, real *change);
/* Change the velocities at the end of a step of h so that the gaps of the loops close. */
CORE_INSIDE void loops_enforce(core *c, real h);
/* Close all gaps of q, and project qd so that they stay closed; moves the handle. */
CORE_INSIDE void loops_close(core *c);

#endif
