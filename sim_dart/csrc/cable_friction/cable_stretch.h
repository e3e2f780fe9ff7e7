/* Friction of cables that stretch along their path. */
#ifndef CARDSFLOW_CABLE_STRETCH_H
#define CARDSFLOW_CABLE_STRETCH_H

#include "../laws/law.h"
#include "bends.h"

/* Use the stretch of a muscle, whose first bend is `bend`, at the last q: replace its tension, the mean
   along the cable, by the tension of its first span. */
CORE_INSIDE void cable_stretch_take(core *c, int32_t muscle, int32_t bend, const cable_stretch *stretch);
/* Set the stretch states to the current stretch of the cables. */
CORE_INSIDE void cable_stretch_start(core *c);
/* Compute the states after a step with the sliding distances bend_next. */
CORE_INSIDE void cable_stretch_advance(core *c, const bent_cable *at, real h);

/* Compute the reduction of the sliding distances due to the stretch that the tension differences in the
   bends cause: x = C P for P = p - slope x. The result replaces p. */
CORE_INSIDE void cable_stretch_yield(const core *c, const bent_cable *at, real *p);

#endif
