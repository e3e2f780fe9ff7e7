/* Curves of quintic Bezier pieces. Each piece connects two points with given slopes.

   Millard, Uchida, Seth & Delp 2013, J. Biomech. Eng. 135, appendix: the second and third control points lie
   on the tangent of one end, the fourth and fifth on the tangent of the other end, towards the corner where
   the tangents intersect. The curviness specifies their distance from the ends. The second derivative is
   zero at both ends, and pieces with the same slope join smoothly. Outside of its pieces a curve continues
   as a straight line. */
#ifndef CARDSFLOW_BEZIER_H
#define CARDSFLOW_BEZIER_H

#include "../../numbers/real.h"

/* Number of cells of equal width in x, for whose ends the parameter of a piece is stored. */
#define BEZIER_CELLS 16
/* Size of a piece: cells per x, the coefficients of x and y beyond the first, the parameters at the ends of
   the cells and their increments. */
#define BEZIER_PIECE (1 + 5 + 5 + 2 * (BEZIER_CELLS + 1))

/* A curve of n pieces has (n + 1) knots x, y, slope, then the pieces. */
#define BEZIER_SIZE(pieces) (3 * ((pieces) + 1) + BEZIER_PIECE * (pieces))

/* Complete a curve whose knots are set. `curviness` of every piece, from 0 to 1. */
CORE_INSIDE void bezier_prepare(real *curve, int pieces, const real *curviness);

/* Return whether the knots rise in x, and the tangents of neighbouring knots intersect between them in x and
   y, so that no piece turns back. */
CORE_INSIDE int bezier_is_sound(const real *curve, int pieces);

/* Return y(x) and, unless `slope` is NULL, dy/dx. */
CORE_INSIDE real bezier_value(const real *curve, int pieces, real x, real *slope);

/* Compute y(x) of several curves, whose operations overlap; the result is bit-identical. */
#define BEZIER_POINTS 3
typedef struct {
    const real *curve;
    int pieces;
    real x;
} bezier_point;
CORE_INSIDE void bezier_values(const bezier_point *of, real y[BEZIER_POINTS]);

#endif
