/* Whether and on which side a cable goes round a surface by the rules of MuJoCo and OpenSim. */
#ifndef CARDSFLOW_WRAP_RULES_H
#define CARDSFLOW_WRAP_RULES_H

#include "../cable.h"

/* RULE_MEETS: the straight line meets the surface, so that OpenSim looks at no other segment. */
enum { RULE_STRAIGHT = 0, RULE_WRAPS, RULE_MEETS };

/* One of these, and the way round. `guide`, of MuJoCo's rules the side point in the world, of OpenSim's the
   direction of the quadrant, may be NULL.                                                              */
CORE_INSIDE int wrap_rule(int32_t rule, const wrap_surface *s, const real *guide, const real a[3],
                          const real b[3], wrap_way *way);

#endif
