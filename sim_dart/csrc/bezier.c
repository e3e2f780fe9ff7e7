#include "elementary.h"
#include "bezier.h"

#include <math.h>
#include <stddef.h>

#define MOST_STEPS 40
/* Of Newton's rule: what is left is about its square. */
#define LAST_STEP 1e-9

/* Where the tangents of two knots meet; the middle of equal ones. */
static double corner(const double *start, const double *end)
{
    const double turn = start[2] - end[2];
    if (fabs(turn) <= 1.5e-8) return (start[0] + end[0]) / 2;
    return (end[1] - start[1] - end[0] * end[2] + start[0] * start[2]) / turn;
}

void bezier_prepare(double *curve, int pieces, const double *curviness)
{
    double *inner = curve + 3 * (pieces + 1);
    for (int i = 0; i < pieces; i++, inner += 4) {
        const double *start = curve + 3 * i, *end = start + 3, part = 0.1 + 0.8 * curviness[i];
        const double x = corner(start, end), y = (x - end[0]) * end[2] + end[1];
        inner[0] = start[0] + part * (x - start[0]), inner[1] = start[1] + part * (y - start[1]);
        inner[2] = end[0] + part * (x - end[0]), inner[3] = end[1] + part * (y - end[1]);
    }
}

int bezier_is_sound(const double *curve, int pieces)
{
    for (int i = 0; i < pieces; i++) {
        const double *start = curve + 3 * i, *end = start + 3, x = corner(start, end);
        if (!(start[0] < x && x < end[0])) return 0;
        const double y = (x - end[0]) * end[2] + end[1], slack = 1e-12;
        if (y < smaller(start[1], end[1]) - slack || y > larger(start[1], end[1]) + slack) return 0;
    }
    return 1;
}

/* A quintic with the control points a, b, b, c, c, d at t, and its derivative by t. */
static double quintic(double a, double b, double c, double d, double t, double *derivative)
{
    const double s = 1 - t, ss = s * s, tt = t * t;
    *derivative = 5 * (ss * ss * (b - a) + 6 * ss * tt * (c - b) + tt * tt * (d - c));
    return ss * ss * (s * a + 5 * t * b) + 10 * ss * tt * (s * b + t * c) + tt * tt * (5 * s * c + t * d);
}

/* t where x(t) is x; x(t) rises. */
static double parameter(const double *start, const double *inner, const double *end, double x)
{
    double low = 0, high = 1, t = (x - start[0]) / (end[0] - start[0]);
    for (int i = 0; i < MOST_STEPS; i++) {
        double rate;
        const double off = quintic(start[0], inner[0], inner[2], end[0], t, &rate) - x;
        if (off < 0)
            low = t;
        else
            high = t;
        double next = t - off / rate;
        if (!(next >= low && next <= high)) next = (low + high) / 2;
        const double moved = fabs(next - t);
        t = next;
        if (moved <= LAST_STEP) break;
    }
    return t;
}

double bezier_value(const double *curve, int pieces, double x, double *slope)
{
    const double *last = curve + 3 * pieces;
    if (x <= curve[0] || x >= last[0]) {
        const double *knot = x <= curve[0] ? curve : last;
        if (slope) *slope = knot[2];
        return knot[2] == 0 ? knot[1] : knot[1] + knot[2] * (x - knot[0]);
    }
    const double *start = curve, *inner = curve + 3 * (pieces + 1);
    while (x >= start[3]) start += 3, inner += 4;
    const double t = parameter(start, inner, start + 3, x);
    double x_rate, y_rate;
    const double y = quintic(start[1], inner[1], inner[3], start[4], t, &y_rate);
    if (!slope) return y;
    quintic(start[0], inner[0], inner[2], start[3], t, &x_rate);
    *slope = y_rate / x_rate;
    return y;
}
