/* Curves of quintic Bezier pieces, each an elbow between two points with given slopes.

   Millard, Uchida, Seth & Delp 2013, J. Biomech. Eng. 135, appendix: the second and third control points
   lie on the tangent of one end, the fourth and fifth on that of the other, towards the corner in which
   the tangents meet; the curviness says how far. So the second derivative is zero at both ends, and
   pieces with the same slope join smoothly. Outside of its pieces a curve continues as a line.          */
#ifndef CARDSFLOW_BEZIER_H
#define CARDSFLOW_BEZIER_H

#include "../../numbers/real.h"

/* Cells of equal width in x, at whose ends a piece's parameter is known in advance. */
#define BEZIER_CELLS 16
/* Of a piece: cells per x, the coefficients of x and y beyond the first, the parameters at the cells' ends
   and what they grow by in a cell there.                                                               */
#define BEZIER_PIECE (1 + 5 + 5 + 2 * (BEZIER_CELLS + 1))

/* A curve of n pieces is (n + 1) knots x, y, slope, then the pieces. */
#define BEZIER_SIZE(pieces) (3 * ((pieces) + 1) + BEZIER_PIECE * (pieces))

/* Complete a curve whose knots are set. `curviness` of every piece, from 0 to 1. */
CORE_INSIDE void bezier_prepare(real *curve, int pieces, const real *curviness);

/* Whether the knots rise in x, and the tangents of every two meet between them in x and y, so that no
   piece turns back.                                                                                   */
CORE_INSIDE int bezier_is_sound(const real *curve, int pieces);

/* y(x) and, unless `slope` is NULL, dy/dx. */
CORE_INSIDE real bezier_value(const real *curve, int pieces, real x, real *slope);

/* y(x) of some curves, which overlap in time; the same bits. */
#define BEZIER_POINTS 3
typedef struct {
    const real *curve;
    int pieces;
    real x;
} bezier_point;
CORE_INSIDE void bezier_values(const bezier_point *of, real y[BEZIER_POINTS]);

#endif
