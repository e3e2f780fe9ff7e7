/* A cable over one sphere or cylinder, in closed form. wrap_inside.c contains the path inside, ellipsoid/
   the path over an ellipsoid.

   Seen along the axis (of the plane through both ends and the centre, for a sphere) the cable consists of
   two tangents and an arc on a circle. On a cylinder it climbs at a constant slope along that planar path P,
   so that it is a straight line on the unrolled surface: l = sqrt(P^2 + h^2).

   If the straight line does not meet the circle, the cable is straight on either side; contact begins and
   ends smoothly. Otherwise the side selects the path. Without a side the shorter path is used, which changes
   sides when both are equal. A cable on the longer path around a specified side jumps when its straight line
   becomes free: there it slips off. The length is also continuous for

     an end inside the surface: the circle shrinks until it passes through the end;
     the ends of a cylinder: beyond them, where the straight line passes the axis, the circle shrinks to zero
     within one radius, as if the surface were tapered.

   In both cases the length also depends on its ends through the radius R: dl/dR = angle * P / l. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-tree-vectorize") /* packing vectors of three into pairs costs more than it saves */
#endif
#include "wrap.h"

#include "../blob/layout.h"
#include "../math/elementary.h"
#include "../math/quick_arc.h"
#include "../math/vectors.h"
#include "../optional_parts.h"
#include "ellipsoid/ellipsoid.h"
#include "wrap_inside.h"

#include <math.h>
#include <string.h>

#define MAX_TURNS 1e9 /* fits into an int, and is far above any stored number of turns */

/* The ends relative to the axis, and the circle. */
typedef struct {
    real a[3], b[3];     /* perpendicular to the axis */
    real za, zb;         /* along the axis */
    real aa, bb, dd, ad; /* products of a, b and d = b - a */
    real x[3], xx;       /* a x b and its square */
    real cross;          /* of a and b, about the normal */
    real normal[3];      /* axis of the contact: the axis, or the normal of the plane of both ends */
    real R, RR;          /* the circle's radius and its square */
    real slope;          /* of the radius along a tapered axis */
    int is_shrunk;         /* whether the circle passes through an end that would be inside */
} view;

/* Return the position on the straight line, 0 to 1, nearest to the axis. */
static real nearest_position(const view *v)
{
    return value_of(v->ad) >= 0 ? 0 : value_of(-v->ad) >= value_of(v->dd) ? 1 : -v->ad / v->dd;
}

/* Return the radius of a cylinder where the straight line passes its axis, and its slope along the axis. */
static real tapered_radius(const wrap_surface *s, const view *v, real *slope)
{
    const real z = v->za + nearest_position(v) * (v->zb - v->za), beyond = fabs(z) - s->half;
    if (value_of(beyond) <= 0) return s->radius;
    if (value_of(beyond) >= value_of(s->radius)) return 0;
    const real phase = PI * beyond / s->radius;
    *slope = -0.5 * PI * sine(phase) * (value_of(z) < 0 ? -1 : 1);
    return 0.5 * s->radius * (1 + cosine(phase));
}

/* Compute the circle: its radius is not larger than the distance of either end, so that both are on it or
   outside. */
static inline void fit_circle(const wrap_surface *s, view *v)
{
    v->slope = 0;
    v->R = value_of(s->half) > 0 ? tapered_radius(s, v, &v->slope) : s->radius;
    v->RR = v->R * v->R;
    const real inner = value_of(v->aa) < value_of(v->bb) ? v->aa : v->bb;
    v->is_shrunk = value_of(inner) < value_of(v->RR);
    if (v->is_shrunk) v->RR = inner, v->R = sqrt(inner);
}

/* Compute the view. Return whether the straight line does not meet the circle: if the nearest point is
   between the ends, its distance is |a x b| / |d|; if it is an end, its distance is at least the radius. */
static inline int compute_view(const wrap_surface *s, const real A[3], const real B[3], view *v)
{
    const real *n = s->axis, *c = s->centre;
    const real p[3] = {A[0] - c[0], A[1] - c[1], A[2] - c[2]}, q[3] = {B[0] - c[0], B[1] - c[1], B[2] - c[2]};
    const int has_axis = s->kind == SURFACE_CYLINDER;
    v->za = has_axis ? dot3(p, n) : 0, v->zb = has_axis ? dot3(q, n) : 0;
    const real a[3] = {p[0] - v->za * n[0], p[1] - v->za * n[1], p[2] - v->za * n[2]};
    const real b[3] = {q[0] - v->zb * n[0], q[1] - v->zb * n[1], q[2] - v->zb * n[2]};
    const real d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    for (int k = 0; k < 3; k++) v->a[k] = a[k], v->b[k] = b[k];
    v->aa = dot3(a, a), v->bb = dot3(b, b), v->dd = dot3(d, d), v->ad = dot3(a, d);
    fit_circle(s, v);
    cross3(v->x, a, b);
    v->xx = dot3(v->x, v->x);
    const int is_before = value_of(v->ad) >= 0, is_behind = value_of(-v->ad) >= value_of(v->dd);
    const int is_past = value_of(v->xx) >= value_of(v->RR * v->dd);
    return is_before | is_behind | is_past;
}

/* Compute the axis about which the contact turns. */
static inline void find_normal(const wrap_surface *s, view *v)
{
    if (s->kind == SURFACE_CYLINDER) {
        v->cross = dot3(v->x, s->axis);
        memcpy(v->normal, s->axis, sizeof v->normal);
        return;
    }
    v->cross = sqrt(v->xx);
    const real per = value_of(v->cross) > 0 ? 1 / v->cross : 0;
    for (int k = 0; k < 3; k++) v->normal[k] = per * v->x[k];
    if (!(value_of(v->cross) > 0)) unit_across(v->normal, value_of(v->aa) > 0 ? v->a : s->axis);
}

int wrap_is_clear(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3])
{
    if (USES_ELLIPSOIDS && s->kind == SURFACE_ELLIPSOID) return ellipsoid_is_clear(s, a, b);
    if (way->side == WRAP_INSIDE) return wrap_inside_is_clear(s, a, b);
    view v;
    return compute_view(s, a, b, &v);
}

/* Sense of turning, whether this is the longer path, and the additional whole turns. */
typedef struct {
    int sense, is_long, turns;
} course;

static inline course choose_course(const wrap_surface *s, const wrap_way *way, const view *v, int is_clear)
{
    const int natural = value_of(v->cross) >= 0 ? 1 : -1;
    course c = {natural, 0, way->turns};
    if (way->is_forced) {
        c.sense = way->side, c.is_long = c.sense != natural;
        return c;
    }
    if (!way->side || (is_clear && !way->turns)) return c;
    /* the normal of a sphere has no side: the sense refers to its z axis */
    const int facing = s->kind == SURFACE_SPHERE && value_of(dot3(v->normal, s->axis)) < 0 ? -1 : 1;
    c.sense = way->side * facing;
    c.is_long = c.sense != natural;
    if (c.is_long && is_clear) c.turns--; /* not yet around to its side */
    return c;
}

/* Return the angle from a to b on the shorter path, positive about the normal. */
static real shorter_turn(const view *v)
{
    return arc_tangent(v->cross, dot3(v->a, v->b));
}

/* Return the course that continues a stored turning angle: the cable has turned by less than half a turn
   since. */
static course continue_turns(const view *v, real remembered)
{
    const real full_turns = round((remembered - shorter_turn(v)) / (2 * PI));
    course c = {value_of(v->cross) >= 0 ? 1 : -1, 0, 0};
    if (full_turns == 0 || !(value_of(fabs(full_turns)) < MAX_TURNS)) return c;
    c.turns = (int)fabs(full_turns);
    c.is_long = (value_of(full_turns) > 0) != (c.sense > 0);
    c.sense = value_of(full_turns) > 0 ? 1 : -1;
    c.turns -= c.is_long;
    return c;
}

static real turning(const view *v, const course *c)
{
    const real angle = fabs(shorter_turn(v));
    return c->sense * ((c->is_long ? 2 * PI - angle : angle) + 2 * PI * c->turns);
}

/* Return the angle between the tangent points, from the product of three complex numbers:

     exp(i angle) ~ (a.b + i sense cross) (R - i ta) (R - i tb), with ta and tb the lengths of the tangents.

   The result is the equivalent angle in an interval of 3/2 pi that contains all possible angles. */
static inline real contact_angle(const view *v, const course *c, real ta, real tb)
{
    const real re = v->RR - ta * tb, im = -v->R * (ta + tb);
    const real ab = v->aa + v->ad, turned = c->sense * v->cross;
    const real angle = quick_arc_tangent(ab * im + turned * re, ab * re - turned * im);
    const real middle = (c->is_long ? PI : 0) + (value_of(re) > 0 ? PI / 4 : -PI / 4);
    return value_of(angle) < value_of(middle - PI)   ? angle + 2 * PI
           : value_of(angle) > value_of(middle + PI) ? angle - 2 * PI
                                                     : angle;
}

/* Add the effect of the taper to the gradient: dR = slope dz, z = za + t h, t = -a.d / d.d. */
static void add_taper(const wrap_surface *s, const view *v, real rate, pull *out)
{
    const real t = nearest_position(v), h = v->zb - v->za;
    const real scale = value_of(t) > 0 && value_of(t) < 1 ? rate * h / v->dd : 0;
    for (int k = 0; k < 3; k++) {
        const real d = v->b[k] - v->a[k];
        out->entering[k] -= rate * (1 - t) * s->axis[k] + scale * (v->a[k] + (2 * t - 1) * d);
        out->leaving[k] += rate * t * s->axis[k] - scale * (v->a[k] + 2 * t * d);
    }
}

/* Add the effect of the radius: dl/dR = rate. R is the distance of an end, or depends on the taper. */
static void add_radius(const wrap_surface *s, const view *v, real rate, pull *out)
{
    if (!v->is_shrunk)
        add_taper(s, v, rate * v->slope, out);
    else if (value_of(v->R) > 0 && value_of(v->aa) <= value_of(v->bb))
        for (int k = 0; k < 3; k++) out->entering[k] -= rate / v->R * v->a[k];
    else if (value_of(v->R) > 0)
        for (int k = 0; k < 3; k++) out->leaving[k] += rate / v->R * v->b[k];
}

/* Compute scale (across n x end + along end) + climb n. */
static inline void set_direction(const view *v, const real end[3], real scale, real across, real along,
                                 real climb, real out[3])
{
    real turned[3];
    cross3(turned, v->normal, end);
    for (int k = 0; k < 3; k++)
        out[k] = scale * (across * turned[k] + along * end[k]) + climb * v->normal[k];
}

/* Compute the directions of the tangents in the plane, times the squared distances of their ends: -ta a + R
   n x a at the start, tb b + R n x b at the end. They turn with the climb. */
static inline void pull_along(const view *v, int sense, real ta, real tb, int ends, pull *out)
{
    const real P = ta + tb + v->R * out->angle, h = v->zb - v->za, sR = sense * v->R;
    real climb = 0;
    const real both = v->aa * v->bb, per_both = value_of(both) > 0 ? 1 / both : 0;
    real ia = v->bb * per_both, ib = v->aa * per_both;
    out->length = P;
    if (h != 0) {
        const real square = P * P + h * h, per_square = 1 / square;
        out->length = sqrt(square);
        const real per = out->length * per_square; /* so that root and quotient are computed in parallel */
        climb = per * h, ia *= per * P, ib *= per * P;
    }
    if (ends & ENTERING) set_direction(v, v->a, ia, sR, -ta, climb, out->entering);
    if (ends & LEAVING) set_direction(v, v->b, ib, sR, tb, climb, out->leaving);
}

/* Return the sense of turning if the cable touches, 0 if it is straight. `plain`, only if not NULL, is the
   pull without the effect of a changing radius. `v` is computed by wrap_is_clear. */
static inline int compute_contact(const wrap_surface *s, const wrap_way *way, view *v, int is_clear, int ends,
                                  pull *out, pull *plain)
{
    const int changes = v->is_shrunk || v->slope != 0; /* whether the radius depends on the ends */
    find_normal(s, v);
    const int is_continued = way->is_followed && !isnan(way->remembered);
    const course c = is_continued ? continue_turns(v, way->remembered) : choose_course(s, way, v, is_clear);
    if (way->is_followed) out->turning = turning(v, &c);
    const real ta = sqrt(v->aa - v->RR), tb = sqrt(v->bb - v->RR);
    out->angle = contact_angle(v, &c, ta, tb) + 2 * PI * c.turns;
    if (value_of(out->angle) <= 0 || (is_clear && !c.turns && !c.is_long)) return 0;
    pull_along(v, c.sense, ta, tb, changes ? BOTH_ENDS : ends, out);
    if (plain) *plain = *out;
    if (changes)
        add_radius(s, v, out->angle * (ta + tb + v->R * out->angle) / out->length, out);
    return c.sense;
}

int wrap_pull(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3], int ends,
              pull *out)
{
    if (USES_ELLIPSOIDS && s->kind == SURFACE_ELLIPSOID) return ellipsoid_pull(s, way, a, b, out);
    if (way->side == WRAP_INSIDE) return wrap_inside_pull(s, a, b, out);
    view v;
    const int is_clear = compute_view(s, a, b, &v);
    if (is_clear && !way->turns && !way->is_forced) return 0;
    return compute_contact(s, way, &v, is_clear, ends, out, NULL) != 0;
}

static void run_straight(const real A[3], const real B[3], real t, contact *out)
{
    const real d[3] = {B[0] - A[0], B[1] - A[1], B[2] - A[2]};
    const real length = sqrt(dot3(d, d)), per = value_of(length) > 0 ? 1 / length : 0;
    out->pull.length = length;
    out->pull.angle = 0;
    for (int k = 0; k < 3; k++) {
        out->pull.entering[k] = out->pull.leaving[k] = per * d[k];
        out->touch[k] = out->lift[k] = A[k] + t * d[k];
        out->axis[k] = 0;
    }
}

/* The lengths of the tangents along the climbing cable are those in the plane times length / P. */
void wrap_over(const wrap_surface *s, const wrap_way *way, const real A[3], const real B[3],
               contact *out)
{
    view v;
    pull plain;
    out->pull.turning = 0;
    if (USES_ELLIPSOIDS && s->kind == SURFACE_ELLIPSOID) {
        if (!ellipsoid_over(s, way, A, B, out)) run_straight(A, B, ellipsoid_nearest(s, A, B), out);
        return;
    }
    if (way->side == WRAP_INSIDE) {
        if (!wrap_inside_over(s, A, B, out)) run_straight(A, B, 0.5, out);
        return;
    }
    const int is_clear = compute_view(s, A, B, &v), is_free = is_clear && !way->turns && !way->is_followed && !way->is_forced;
    const int sense = is_free ? 0 : compute_contact(s, way, &v, is_clear, BOTH_ENDS, &out->pull, &plain);
    if (!sense) {
        run_straight(A, B, nearest_position(&v), out);
        return;
    }
    const real ta = sqrt(v.aa - v.RR), tb = sqrt(v.bb - v.RR), P = ta + tb + v.R * plain.angle;
    const real stretch = value_of(P) > 0 ? plain.length / P : 1;
    for (int k = 0; k < 3; k++) {
        out->touch[k] = A[k] + stretch * ta * plain.entering[k];
        out->lift[k] = B[k] - stretch * tb * plain.leaving[k];
        out->axis[k] = sense * v.normal[k];
    }
}
