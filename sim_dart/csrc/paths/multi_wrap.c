/* A taut cable over several surfaces in one segment, in order.

   Between two parts the cable passes a free point X in the gap. For given points every part is in closed
   form. The cable is taut if the length l(X1, X2, ...) is minimal: then the directions before and after
   every X agree. Two kinds of steps are used:

     tighten  X moves to the middle of the free span. The length never grows; convergence is quadratic in the
              plane of two circles, and linear perpendicular to it;
     Newton   in the plane perpendicular to each span, with the gradient in closed form and its derivatives by
              differences; accepted only if the length decreases or the directions agree better.

   At most ITERATIONS of both are used. The length is stationary, so its error is the square of the error of
   the directions.

   The side of a cylinder is selected first, and is kept by following the turning angle, so that the length
   is smooth during the iteration. With a specified side, the straight line between the via points decides
   whether the cable touches, as for a single surface. Without a specified side, both sides are evaluated and
   the shortest cable of all combinations is used; it does not jump. Spheres are passed on the shorter way,
   since no other way is taut. As several taut paths past two spheres can exist, the search starts on both
   sides of spheres and ellipsoids. Inside a surface only one path exists. The search may miss the shortest
   path; the length jumps if it finds a different one. All this applies to the first FREE_SIDES of such
   surfaces; further ones are passed on the side of the straight line.

   Overlapping surfaces have no gap. The point then lies inside one of them, whose circle shrinks to it. The
   cable has a finite length, but not the minimal one, and the directions may not agree. */
#include "multi_wrap.h"

#include "../blob/layout.h"
#include "../math/elementary.h"
#include "../math/vectors.h"
#include "pulley.h"
#include "wrap.h"

#include <math.h>
#include <string.h>

#define ITERATIONS 60
#define FREE_SIDES 4
#define AGREEMENT PRECISE(1e-13, 1e-6) /* tolerance of directions, which are about 1 */
#define MIN_DECREASE PRECISE(1e-11, 1e-4) /* the same: if it no longer decreases, only rounding errors remain */
#define DIFFERENCE PRECISE(1e-7, 3e-4) /* relative to the length of a span, for second derivatives */
#define LENGTH_ROUNDING PRECISE(1e-14, 5e-6)  /* relative to a length */
#define MIN_PIVOT PRECISE(1e-12, 1e-5)
#define UNKNOWNS (2 * MAX_SEQUENCE)

typedef struct {
    const sequence_part *parts;
    int count;
    real points[MAX_SEQUENCE + 2][3];
    contact contacts[MAX_SEQUENCE + 1];
    real followed[MAX_SEQUENCE + 1]; /* turning angles about cylinders */
    real length, disagreement;
} cable;

static int is_followed(const sequence_part *p)
{
    return p->surface && p->surface->kind == SURFACE_CYLINDER && p->way.side != WRAP_INSIDE;
}

/* `from`: of an ellipsoid, a contact with similar ends, or NULL. */
static void evaluate_part(const cable *c, int i, const real a[3], const real b[3], const contact *from, contact *out)
{
    const sequence_part *p = c->parts + i;
    const wrap_way followed = {.is_followed = 1, .remembered = c->followed[i]};
    const int is_ellipsoid = p->surface && p->surface->kind == SURFACE_ELLIPSOID;
    const int is_fixed_side = p->way.side == WRAP_INSIDE || is_ellipsoid;
    const wrap_way shorter = {.side = is_fixed_side ? p->way.side : 0, .turns = p->way.turns, .from = from};
    if (p->surface)
        wrap_over(p->surface, is_followed(p) ? &followed : &shorter, a, b, out);
    else
        pulley_off(a, p->v, p->radius, b, out);
}

static void evaluate_cable(cable *c)
{
    c->length = c->disagreement = 0;
    for (int i = 0; i < c->count; i++) {
        const contact before = c->contacts[i]; /* its angle is 0 in the first evaluation */
        evaluate_part(c, i, c->points[i], c->points[i + 1], &before, c->contacts + i);
        c->length += c->contacts[i].pull.length;
        if (is_followed(c->parts + i)) c->followed[i] = c->contacts[i].pull.turning;
        for (int k = 0; i && k < 3; k++) {
            const real r = fabs(c->contacts[i - 1].pull.leaving[k] - c->contacts[i].pull.entering[k]);
            if (value_of(r) > value_of(c->disagreement)) c->disagreement = r;
        }
    }
}

static void pull_tight(cable *c)
{
    for (int i = 1; i < c->count; i++)
        for (int k = 0; k < 3; k++)
            c->points[i][k] = 0.5 * (c->contacts[i - 1].lift[k] + c->contacts[i].touch[k]);
    evaluate_cable(c);
}

/* Compute two unit vectors perpendicular to the span at a point. */
static void span_plane(const cable *c, int i, real plane[2][3])
{
    const real *left = c->contacts[i - 1].pull.leaving, *right = c->contacts[i].pull.entering;
    real u[3], e[3] = {0, 0, 0};
    for (int k = 0; k < 3; k++) u[k] = left[k] + right[k];
    int minimum = 0;
    for (int k = 1; k < 3; k++)
        if (value_of(fabs(u[k])) < value_of(fabs(u[minimum]))) minimum = k;
    e[minimum] = 1;
    cross3(plane[0], u, e);
    cross3(plane[1], u, plane[0]);
    for (int j = 0; j < 2; j++) {
        const real norm = sqrt(dot3(plane[j], plane[j]));
        for (int k = 0; k < 3; k++) plane[j][k] = value_of(norm) > 0 ? plane[j][k] / norm : 0;
    }
}

/* Solve H x = r; x replaces r. Return 0 if H is singular. */
static int eliminate(real H[UNKNOWNS][UNKNOWNS], real *r, int n)
{
    for (int i = 0; i < n; i++) {
        int best = i;
        for (int k = i + 1; k < n; k++)
            if (value_of(fabs(H[k][i])) > value_of(fabs(H[best][i]))) best = k;
        if (!(value_of(fabs(H[best][i])) > MIN_PIVOT)) return 0;
        for (int k = 0; k < n; k++) {
            const real h = H[i][k];
            H[i][k] = H[best][k], H[best][k] = h;
        }
        const real swapped = r[i];
        r[i] = r[best], r[best] = swapped;
        for (int k = i + 1; k < n; k++) {
            const real factor = H[k][i] / H[i][i];
            for (int j = i; j < n; j++) H[k][j] -= factor * H[i][j];
            r[k] -= factor * r[i];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++) r[i] -= H[i][k] * r[k];
        r[i] /= H[i][i];
    }
    return 1;
}

/* Add the change of the gradient at the points i - 1, i and i + 1 when point i moves by h along e. */
static void add_column(const cable *c, int i, const real e[3], real h, real (*planes)[2][3],
                       real H[UNKNOWNS][UNKNOWNS], int column)
{
    contact before, after;
    real moved[3];
    for (int k = 0; k < 3; k++) moved[k] = c->points[i][k] + h * e[k];
    evaluate_part(c, i - 1, c->points[i - 1], moved, c->contacts + i - 1, &before);
    evaluate_part(c, i, moved, c->points[i + 1], c->contacts + i, &after);
    const pull *was_before = &c->contacts[i - 1].pull, *was_after = &c->contacts[i].pull;
    for (int j = 0; j < 2; j++)
        for (int k = 0; k < 3; k++) {
            const real entering = (before.pull.entering[k] - was_before->entering[k]) / h;
            const real leaving = (before.pull.leaving[k] - was_before->leaving[k]) / h;
            const real next_entering = (after.pull.entering[k] - was_after->entering[k]) / h;
            const real next_leaving = (after.pull.leaving[k] - was_after->leaving[k]) / h;
            H[2 * (i - 1) + j][column] += planes[i][j][k] * (leaving - next_entering);
            if (i > 1) H[2 * (i - 2) + j][column] -= planes[i - 1][j][k] * entering;
            if (i < c->count - 1) H[2 * i + j][column] += planes[i + 1][j][k] * next_leaving;
        }
}

/* Compute the derivatives of the gradient perpendicular to the spans, and the negative gradient. Return 0 if
   a part has zero length. */
static int linearise(const cable *c, real (*planes)[2][3], real H[UNKNOWNS][UNKNOWNS], real *r)
{
    memset(H, 0, UNKNOWNS * sizeof *H);
    for (int i = 1; i < c->count; i++) span_plane(c, i, planes[i]);
    for (int i = 1; i < c->count; i++)
        for (int j = 0; j < 2; j++) {
            const real *e = planes[i][j];
            const real h = DIFFERENCE * (c->contacts[i - 1].pull.length + c->contacts[i].pull.length);
            if (!(value_of(h) > 0)) return 0;
            r[2 * (i - 1) + j] = dot3(c->contacts[i].pull.entering, e) - dot3(c->contacts[i - 1].pull.leaving, e);
            add_column(c, i, e, h, planes, H, 2 * (i - 1) + j);
        }
    return 1;
}

static void shift(cable *c, const real *step, real (*planes)[2][3])
{
    for (int i = 1; i < c->count; i++)
        for (int k = 0; k < 3; k++)
            c->points[i][k] += step[2 * i - 2] * planes[i][0][k] + step[2 * i - 1] * planes[i][1][k];
}

/* Apply a step if the cable gets shorter, or stays as short with directions that agree better. */
static int is_accepted(cable *c, const real *step, real (*planes)[2][3])
{
    cable next = *c;
    shift(&next, step, planes);
    evaluate_cable(&next);
    const int is_shorter = value_of(next.length) < value_of(c->length * (1 - LENGTH_ROUNDING));
    const int is_as_short = value_of(next.length) <= value_of(c->length * (1 + LENGTH_ROUNDING));
    if (!is_shorter && !(is_as_short && value_of(next.disagreement) < value_of(c->disagreement))) return 0;
    *c = next;
    return 1;
}

/* Take Newton's step. If the length is not convex, the diagonal is increased until the step descends. */
static int step_newton(cable *c)
{
    static const real GROWTH[] = {0, 0.3, 1, 3, 10, 100};
    real H[UNKNOWNS][UNKNOWNS], r[UNKNOWNS], planes[MAX_SEQUENCE + 1][2][3], largest = 0;
    const int n = 2 * (c->count - 1);
    if (!linearise(c, planes, H, r)) return 0;
    for (int i = 0; i < n; i++)
        if (value_of(fabs(H[i][i])) > value_of(largest)) largest = fabs(H[i][i]);
    for (size_t g = 0; g < sizeof GROWTH / sizeof *GROWTH; g++) {
        real grown[UNKNOWNS][UNKNOWNS], step[UNKNOWNS];
        memcpy(grown, H, sizeof H);
        memcpy(step, r, sizeof r);
        for (int i = 0; i < n; i++) grown[i][i] += GROWTH[g] * largest;
        if (eliminate(grown, step, n) && is_accepted(c, step, planes)) return 1;
    }
    return 0;
}

static void tighten(cable *c)
{
    evaluate_cable(c);
    for (int k = 0; k < ITERATIONS && value_of(c->disagreement) > AGREEMENT; k++) {
        const real was = c->disagreement;
        if (k >= 2 && step_newton(c) && value_of(c->disagreement) < value_of(0.5 * was)) continue;
        const real now = c->disagreement;
        if (value_of(now) < MIN_DECREASE && k > 4 && value_of(now) >= value_of(0.5 * was))
            return; /* only rounding errors remain */
        pull_tight(c);
    }
}

/* Let the tangents of the points converge, which the search does not: Newton's steps for the tangents only.
   Each step leaves 1e-7 of the error, since the second derivatives are differences. */
static void converge_tangents(cable *c)
{
    real last = INFINITY;
    for (int round = 0; round < 3; round++) {
        real H[UNKNOWNS][UNKNOWNS], step[UNKNOWNS], planes[MAX_SEQUENCE + 1][2][3];
        const int n = 2 * (c->count - 1);
        if (!linearise(c, planes, H, step) || !eliminate(H, step, n)) return;
        real maximum = 0;
        for (int i = 0; i < n; i++) {
            maximum = larger(maximum, fabs(tangent_of(step[i])));
            step[i] -= value_of(step[i]);
        }
        if (value_of(maximum) >= value_of(last)) return; /* only rounding errors remain */
        last = maximum;
        shift(c, step, planes);
        evaluate_cable(c);
    }
}

/* Return the turning angle about a cylinder from a to b; on side `sense` unless it is 0. */
static real turning_angle(const sequence_part *p, int sense, const real a[3], const real b[3])
{
    const wrap_way natural = {.is_followed = 1, .remembered = NAN};
    wrap_way specified = p->way;
    contact k;
    specified.is_followed = 1, specified.remembered = NAN;
    wrap_over(p->surface, sense ? &natural : &specified, a, b, &k);
    if (!sense) return k.pull.turning;
    const real angle = k.pull.turning * sense;
    return sense * (2 * PI * p->way.turns + (value_of(angle) >= 0 ? angle : 2 * PI + angle));
}

/* Return whether the surface may be passed on either side. */
static int has_free_side(const sequence_part *p)
{
    if (!p->surface || p->way.side == WRAP_INSIDE) return 0;
    return p->surface->kind == SURFACE_SPHERE || !p->way.side;
}

/* Start with points on the straight line from a to b. */
static void begin_cable(cable *c, const sequence_part *parts, int count, const real a[3], const real b[3])
{
    memset(c, 0, sizeof *c);
    c->parts = parts, c->count = count;
    for (int i = 0; i <= count; i++)
        for (int k = 0; k < 3; k++) c->points[i][k] = i < count ? a[k] + (b[k] - a[k]) * i / count : b[k];
    for (int i = 0; i < count; i++)
        if (is_followed(parts + i)) c->followed[i] = turning_angle(parts + i, 0, a, b);
}

/* Pass part i on a side: a cylinder in that sense; a sphere, for -1, on the opposite side of its centre. */
static void select_side(cable *c, int i, int side, const real a[3], const real b[3])
{
    const wrap_surface *s = c->parts[i].surface;
    if (is_followed(c->parts + i)) {
        c->followed[i] = turning_angle(c->parts + i, side, a, b);
        return;
    }
    real d[3], r[3];
    for (int k = 0; k < 3; k++) d[k] = b[k] - a[k], r[k] = a[k] - s->centre[k];
    const real dd = dot3(d, d), t = value_of(dd) > 0 ? -dot3(r, d) / dd : 0;
    for (int k = 0; k < 3; k++) r[k] += t * d[k];
    const real distance = sqrt(dot3(r, r)), across = value_of(distance) > 0 ? 1 + s->radius / distance : 0;
    for (int j = i; j <= i + 1 && side < 0; j++)
        for (int k = 0; k < 3 && j > 0 && j < c->count; k++) c->points[j][k] -= across * r[k];
}

real sequence_solve(const sequence_part *parts, int count, real (*points)[3], contact *contacts)
{
    cable best, c;
    int open[FREE_SIDES], opens = 0;
    for (int i = 0; i < count && opens < FREE_SIDES; i++)
        if (has_free_side(parts + i)) open[opens++] = i;
    for (int combination = 0; combination < 1 << opens; combination++) {
        begin_cable(&c, parts, count, points[0], points[count]);
        for (int k = 0; k < opens; k++)
            select_side(&c, open[k], combination >> k & 1 ? -1 : 1, points[0], points[count]);
        tighten(&c);
        if (!combination || value_of(c.length) < value_of(best.length)) best = c;
    }
    if (HAS_TANGENT) converge_tangents(&best);
    memcpy(points, best.points, (size_t)(count + 1) * sizeof *points);
    memcpy(contacts, best.contacts, (size_t)count * sizeof *contacts);
    return best.length;
}
