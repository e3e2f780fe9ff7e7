/* The constraint forces of loop joints. */
#ifndef CARDSFLOW_LOOPS_H
#define CARDSFLOW_LOOPS_H

#include "../blob/state.h"

/* Factorise J M^-1 J' at the last q, with the last factorisation of M. */
CORE_INSIDE void loops_factor(core *c);
/* rates += M^-1 J' p, so that J rates = goal; NULL for zero. After loops_factor. */
CORE_INSIDE void loops_project(core *c, const real *goal, real *rates);
/* change = what an impulse does to velocities: M^-1 impulse, and with loops what these leave of it. */
CORE_INSIDE void loops_respond(core *c, const real *impulse, real *change);
/* Bring the velocities that a step of h would end with to those that close the loops' gaps. */
CORE_INSIDE void loops_keep(core *c, real h);
/* Close all gaps of q, and bring qd to where they stay closed; moves. */
CORE_INSIDE void loops_close(core *c);

#endif
