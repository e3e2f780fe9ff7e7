/* The wraps of one muscle by other programs' rules, or of one whose points are not all in use. */
#ifndef CARDSFLOW_ROUTE_WRAPS_H
#define CARDSFLOW_ROUTE_WRAPS_H

#include "../cable.h"
#include "../../blob/state.h"

/* One muscle at one pose. */
typedef struct {
    int32_t first, end;        /* its via points */
    int32_t wraps, wrap_count; /* its wraps */
    int32_t conditions, moves; /* where its conditions and moving points begin */
    real factor;               /* by which what is added counts */
} route;

/* A way between two points of a path: its length and -dl/da, dl/db. */
typedef struct {
    real length, entering[3], leaving[3];
} way_between;

/* Between which points each wrap is: wrap_before, the one before it, or -1 if it is in no use. */
CORE_INSIDE void route_wraps_choose(core *c, route *r);

/* The way from point i to j over the wraps between them, with the row's part but for what the points' own
   motion adds; 0 if it is straight.                                                                   */
CORE_INSIDE int route_wraps_over(core *c, const route *r, int32_t i, int32_t j, way_between *way, real *row,
                                 int is_traced);

#endif
