/* The rules of MuJoCo and OpenSim: whether a cable wraps around a surface, and on which side. */
#ifndef CARDSFLOW_WRAP_RULES_H
#define CARDSFLOW_WRAP_RULES_H

#include "../cable.h"

/* RULE_MEETS: the straight line meets the surface, so that OpenSim stops at this segment. */
enum { RULE_STRAIGHT = 0, RULE_WRAPS, RULE_MEETS };

/* Return one of these, and compute the path. `guide` may be NULL; it is the side point in the world for
   MuJoCo's rules, and the direction of the quadrant for OpenSim's. */
CORE_INSIDE int wrap_rule(int32_t rule, const wrap_surface *s, const real *guide, const real a[3],
                          const real b[3], wrap_way *way);

#endif
