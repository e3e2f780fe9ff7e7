/* Friction of cables that stretch all along their path. */
#ifndef CARDSFLOW_CABLE_STRETCH_H
#define CARDSFLOW_CABLE_STRETCH_H

#include "../laws/law.h"
#include "bends.h"

/* The muscle, whose bends begin with `bend`, is stretched so at the last q: of its tension, which is the mean along it,
   make that of its first span. */
CORE_INSIDE void cable_stretch_take(core *c, int32_t muscle, int32_t bend, const cable_stretch *found);
/* The states of stretch are as far on as the cables are stretched. */
CORE_INSIDE void cable_stretch_start(core *c);
/* The states after a step, whose slips are bend_next. */
CORE_INSIDE void cable_stretch_advance(core *c, const bent_cable *at, real h);

/* Of jumps of tension in a cable's bends, how far it slides there less than if it did not stretch by them: x = C P,
   for those P = p - slope x; into p. */
CORE_INSIDE void cable_stretch_yield(const core *c, const bent_cable *at, real *p);

#endif
