/* The wraps of one muscle that has the rules of other programs or conditional via points. */
#ifndef CARDSFLOW_ROUTE_WRAPS_H
#define CARDSFLOW_ROUTE_WRAPS_H

#include "../cable.h"
#include "../../blob/state.h"

/* One muscle at one pose. */
typedef struct {
    int32_t first, end;        /* its via points */
    int32_t wraps, wrap_count; /* its wraps */
    int32_t conditions, moves; /* indices of its first condition and moving point */
    int is_changing;           /* whether it has conditional or moving points */
    real factor;               /* factor of all added terms */
} route;

/* A path between two points: its length and -dl/da, dl/db. */
typedef struct {
    real length, entering[3], leaving[3];
} path_between;

/* Apply the rule of a wrap, except RULE_TAUT, between two points in the world. Return the same as wrap_rule;
   the surface then has no ends. */
CORE_INSIDE int route_wraps_rule(const core *c, int32_t w, const real A[3], const real B[3], wrap_surface *s,
                                 wrap_way *way);

/* Select the points between which each wrap lies: wrap_before is the one before it, or -1 if the wrap is
   inactive. */
CORE_INSIDE void route_wraps_choose(core *c, const route *r);

/* Compute the path from point i to j over the wraps between them, and its contribution to the row without
   the motion of the points on their links. Return 0 if it is straight. */
CORE_INSIDE int route_wraps_over(core *c, const route *r, int32_t i, int32_t j, path_between *way, real *row,
                                 int is_traced);

#endif
