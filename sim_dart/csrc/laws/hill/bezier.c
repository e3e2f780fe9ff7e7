#include "bezier.h"

#include "../../math/elementary.h"

#include <math.h>
#include <stddef.h>

#define MAX_BEZIER_STEPS 40
/* Last step of Newton's method: the remaining error is about its square. */
#define LAST_BEZIER_STEP PRECISE(1e-9, 1e-4)
/* Last step of Chebyshev's method: the remaining error is about its cube. */
#define LAST_LONG_STEP PRECISE(4e-5, 1e-3)
/* Minimum difference of two slopes whose tangents intersect, due to rounding errors. */
#define MIN_TURN PRECISE(1.5e-8, 3.5e-4)
/* Tolerance of values of a curve, which are about 1. */
#define BEZIER_ROUNDING PRECISE(1e-12, 1e-4)

enum { CELLS = 0, X = 1, Y = X + 5, TABLE = Y + 5 };

/* Return where the tangents of two knots intersect; the middle if the slopes are equal. */
static real tangent_intersection(const real *start, const real *end)
{
    const real turn = start[2] - end[2];
    if (value_of(fabs(turn)) <= MIN_TURN) return (start[0] + end[0]) / 2;
    return (end[1] - start[1] - end[0] * end[2] + start[0] * start[2]) / turn;
}

int bezier_is_sound(const real *curve, int pieces)
{
    for (int i = 0; i < pieces; i++) {
        const real *start = curve + 3 * i, *end = start + 3, x = tangent_intersection(start, end);
        if (!(value_of(start[0]) < value_of(x) && value_of(x) < value_of(end[0]))) return 0;
        const real y = (x - end[0]) * end[2] + end[1], slack = BEZIER_ROUNDING;
        const real low = smaller(start[1], end[1]) - slack, high = larger(start[1], end[1]) + slack;
        if (value_of(y) < value_of(low) || value_of(y) > value_of(high)) return 0;
    }
    return 1;
}

/* Compute the coefficients of a quintic with the control points a, b, b, c, c, d, starting with the
   coefficient of t. */
static void expand(real a, real b, real c, real d, real *k)
{
    const real one = 5 * (b - a), two = 30 * (c - b), three = 5 * (d - c);
    k[0] = one, k[1] = -2 * one, k[2] = (6 * one + two) / 3;
    k[3] = -(2 * one + two) / 2, k[4] = (one + two + three) / 5;
}

/* Evaluate a quintic that starts with 0. */
static inline real quintic(const real *k, real t)
{
    const real tt = t * t;
    return t * ((k[0] + t * k[1]) + tt * ((k[2] + t * k[3]) + tt * k[4]));
}

static inline real quintic_rate(const real *k, real t)
{
    const real tt = t * t;
    return (k[0] + t * (2 * k[1])) + tt * ((3 * k[2] + t * (4 * k[3])) + tt * (5 * k[4]));
}

/* Return t with x(t) = x; x(t) rises from 0 to `width`. Newton's method starts from the straight line. */
static real search_parameter(const real *k, real width, real x)
{
    real low = 0, high = 1, t = x / width;
    for (int i = 0; i < MAX_BEZIER_STEPS; i++) {
        const real off = quintic(k, t) - x;
        if (value_of(off) < 0)
            low = t;
        else
            high = t;
        real next = t - off / quintic_rate(k, t);
        if (!(value_of(next) >= value_of(low) && value_of(next) <= value_of(high))) next = (low + high) / 2;
        const real moved = fabs(next - t);
        t = next;
        if (value_of(moved) <= LAST_BEZIER_STEP) break;
    }
    return t;
}

/* Compute a piece between two knots; the tangents have the length share `part`. */
static void prepare_piece(const real *start, real part, real *piece)
{
    const real *end = start + 3, width = end[0] - start[0];
    const real x = tangent_intersection(start, end), y = (x - end[0]) * end[2] + end[1];
    expand(start[0], start[0] + part * (x - start[0]), end[0] + part * (x - end[0]), end[0], piece + X);
    expand(start[1], start[1] + part * (y - start[1]), end[1] + part * (y - end[1]), end[1], piece + Y);
    piece[CELLS] = BEZIER_CELLS / width;
    for (int i = 0; i <= BEZIER_CELLS; i++) {
        real *at = piece + TABLE + 2 * i;
        at[0] = i == 0 ? 0 : i == BEZIER_CELLS ? 1 : search_parameter(piece + X, width, i * width / BEZIER_CELLS);
        at[1] = width / BEZIER_CELLS / quintic_rate(piece + X, at[0]);
    }
}

void bezier_prepare(real *curve, int pieces, const real *curviness)
{
    real *piece = curve + 3 * (pieces + 1);
    for (int i = 0; i < pieces; i++, piece += BEZIER_PIECE)
        prepare_piece(curve + 3 * i, 0.1 + 0.8 * curviness[i], piece);
}

/* Return one step of Chebyshev's method, of third order, from t towards x(t) = x. */
static inline real improve_parameter(const real *k, real x, real t)
{
    const real tt = t * t, per = 1 / quintic_rate(k, t), off = (quintic(k, t) - x) * per;
    const real half_bend = (k[1] + t * (3 * k[2])) + tt * (6 * k[3] + t * (10 * k[4]));
    return t - off * (1 + off * (half_bend * per));
}

/* Position of x on a curve: its piece, which begins at a knot, x relative to the knot, and the approximate
   parameter. */
typedef struct {
    const real *knot, *piece;
    real x, t;
} place;

/* Find the piece and the approximate parameter, by a cubic in its cell. Return 0 if x is outside of all
   pieces. */
static inline int find_piece(const real *curve, int pieces, real x, place *at)
{
    const real *last = curve + 3 * pieces;
    if (!(value_of(x) > value_of(curve[0]) && value_of(x) < value_of(last[0]))) return 0;
    int i = 0;
    for (int k = 1; k < pieces; k++) i += value_of(x) >= value_of(curve[3 * k]);
    at->knot = curve + 3 * i, at->piece = last + 3 + BEZIER_PIECE * i, at->x = x - at->knot[0];
    const real cells = at->x * at->piece[CELLS];
    const int cell = value_of(cells) < BEZIER_CELLS ? (int)value_of(cells) : BEZIER_CELLS - 1;
    const real *end = at->piece + TABLE + 2 * cell, z = cells - cell, grown = end[2] - end[0];
    const real over = grown - end[1], twist = end[3] - grown - over;
    at->t = end[0] + z * (end[1] + z * ((over - twist) + z * twist));
    return 1;
}

/* Iterate from the first step, which changed the parameter from `was` to at->t. Mostly this step is
   sufficient. */
static inline real refine_parameter(const place *at, real was)
{
    real t = at->t;
    for (int i = 0; i < 2; i++) {
        if (value_of(fabs(t - was)) <= LAST_LONG_STEP) return t;
        was = t, t = improve_parameter(at->piece + X, at->x, was);
    }
    if (value_of(fabs(t - was)) <= LAST_LONG_STEP) return t;
    return search_parameter(at->piece + X, at->knot[3] - at->knot[0], at->x);
}

/* Do the same as search, with the tangent of the parameter, which converges one step later than its value. */
static inline real parameter_at(const place *at, real was)
{
    const real t = refine_parameter(at, was), *k = at->piece + X;
    return HAS_TANGENT ? t - (quintic(k, t) - at->x) / quintic_rate(k, t) : t;
}

static real value_outside(const real *curve, int pieces, real x, real *slope)
{
    const real *last = curve + 3 * pieces, *knot = value_of(x) <= value_of(curve[0]) ? curve : last;
    if (slope) *slope = knot[2];
    return knot[2] == 0 ? knot[1] : knot[1] + knot[2] * (x - knot[0]);
}

real bezier_value(const real *curve, int pieces, real x, real *slope)
{
    place at;
    if (!find_piece(curve, pieces, x, &at)) return value_outside(curve, pieces, x, slope);
    const real was = at.t;
    at.t = improve_parameter(at.piece + X, at.x, was);
    const real t = parameter_at(&at, was);
    if (slope) *slope = quintic_rate(at.piece + Y, t) / quintic_rate(at.piece + X, t);
    return at.knot[1] + quintic(at.piece + Y, t);
}

void bezier_values(const bezier_point *of, real y[BEZIER_POINTS])
{
    place at[BEZIER_POINTS];
    real was[BEZIER_POINTS] = {0};
    int is_within[BEZIER_POINTS];
    for (int i = 0; i < BEZIER_POINTS; i++) {
        is_within[i] = find_piece(of[i].curve, of[i].pieces, of[i].x, at + i);
        if (is_within[i]) was[i] = at[i].t;
    }
    for (int i = 0; i < BEZIER_POINTS; i++)
        if (is_within[i]) at[i].t = improve_parameter(at[i].piece + X, at[i].x, was[i]);
    for (int i = 0; i < BEZIER_POINTS; i++)
        y[i] = is_within[i] ? at[i].knot[1] + quintic(at[i].piece + Y, parameter_at(at + i, was[i]))
                            : value_outside(of[i].curve, of[i].pieces, of[i].x, NULL);
}
