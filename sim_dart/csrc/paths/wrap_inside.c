/* A cable inside a sphere or a cylinder: the surface is a hole that it is led through.

   Seen along the axis (of the plane through both ends and the centre, for a sphere) a straight line that
   passes through the circle, or ends in it, is free. Else the cable touches the circle from within at the
   point p where |a - p| + |p - b| is least: there both parts are at the same angle to the radius. With p
   turned by the angle z from a towards b, which is G away, the difference of those angles is zero if

       sin(2 z - G) - R/|b| sin z + R/|a| sin(G - z) = 0,

   once among the points that both ends see. On a cylinder the cable climbs evenly along that planar way, as
   it does outside. Coming to touch is smooth; and where the cable touches does not count for the gradient,
   as p is where the length is least.                                                                    */
#include "wrap_inside.h"

#include "../blob/layout.h"
#include "../math/elementary.h"
#include "../math/root.h"
#include "../math/vectors.h"

#include <math.h>

/* Of Newton's rule, in [rad]: what is left is about its square. */
#define LAST_WRAP_STEP PRECISE(1e-8, 1e-4)

typedef struct {
    real a[3], b[3], za, zb; /* the ends across the axis and along it */
    real ra, rb, G;          /* their distances and the angle between them */
    real normal[3];          /* about which it is positive */
} ends;

/* Whether the cable touches; `at` then. */
static int see(const wrap_surface *s, const real A[3], const real B[3], ends *at)
{
    const real *n = s->axis, RR = s->radius * s->radius;
    real *a = at->a, *b = at->b, d[3], x[3];
    for (int k = 0; k < 3; k++) a[k] = A[k] - s->centre[k], b[k] = B[k] - s->centre[k];
    at->za = at->zb = 0;
    if (s->kind == SURFACE_CYLINDER) {
        at->za = dot3(a, n), at->zb = dot3(b, n);
        for (int k = 0; k < 3; k++) a[k] -= at->za * n[k], b[k] -= at->zb * n[k];
    }
    for (int k = 0; k < 3; k++) d[k] = b[k] - a[k];
    const real aa = dot3(a, a), bb = dot3(b, b), dd = dot3(d, d), ad = dot3(a, d);
    if (!(value_of(aa) > value_of(RR) && value_of(bb) > value_of(RR))) return 0;
    cross3(x, a, b);
    const real xx = dot3(x, x), cross = sqrt(xx);
    if (value_of(ad) < 0 && value_of(-ad) < value_of(dd) && value_of(xx) <= value_of(RR * dd)) return 0;
    at->ra = sqrt(aa), at->rb = sqrt(bb), at->G = arc_tangent(cross, aa + ad);
    for (int k = 0; k < 3; k++) at->normal[k] = value_of(cross) > 0 ? x[k] / cross : 0;
    return 1;
}

typedef struct {
    real G, by_a, by_b; /* R/|a|, R/|b| */
} mirror;

static real off_mirror(const void *data, real z, real *derivative)
{
    const mirror *m = data;
    real sine_z, cosine_z, sine_rest, cosine_rest;
    sine_cosine(z, &sine_z, &cosine_z);
    sine_cosine(m->G - z, &sine_rest, &cosine_rest);
    *derivative = 2 * (cosine_z * cosine_rest + sine_z * sine_rest) - m->by_b * cosine_z - m->by_a * cosine_rest;
    return sine_z * cosine_rest - cosine_z * sine_rest - m->by_b * sine_z + m->by_a * sine_rest;
}

/* The angle from a to where the cable touches. Neither end sees further than its tangent. */
static real touched_angle(const ends *at, real R)
{
    const mirror m = {at->G, R / at->ra, R / at->rb};
    const real seen_a = arc_cosine(m.by_a), seen_b = arc_cosine(m.by_b);
    const real low = larger(0, at->G - seen_b), high = larger(low, smaller(at->G, seen_a));
    const real guess = at->G * (1 - m.by_a) / ((1 - m.by_a) + (1 - m.by_b));
    return bracketed_root(off_mirror, &m, low, high, smaller(larger(guess, low), high), LAST_WRAP_STEP);
}

/* From the centre's level to the touching point, across the axis: R (cos z a + sin z n x a) / |a|. */
static void touched_point(const ends *at, real R, real p[3])
{
    real s, c, across[3];
    sine_cosine(touched_angle(at, R), &s, &c);
    cross3(across, at->normal, at->a);
    for (int k = 0; k < 3; k++) p[k] = R / at->ra * (c * at->a[k] + s * across[k]);
}

/* The parts before and after p have their directions in the plane, and climb alike. */
static real pull_through(const wrap_surface *s, const ends *at, const real p[3], pull *out)
{
    real u[3], v[3], turn[3];
    for (int k = 0; k < 3; k++) u[k] = p[k] - at->a[k], v[k] = at->b[k] - p[k];
    const real before = sqrt(dot3(u, u)), after = sqrt(dot3(v, v)), P = before + after, h = at->zb - at->za;
    cross3(turn, u, v);
    out->length = sqrt(P * P + h * h);
    out->angle = arc_tangent(sqrt(dot3(turn, turn)), dot3(u, v));
    const real level = P / out->length, climb = h / out->length;
    for (int k = 0; k < 3; k++) {
        out->entering[k] = level / before * u[k] + climb * s->axis[k];
        out->leaving[k] = level / after * v[k] + climb * s->axis[k];
    }
    return before / P;
}

int wrap_inside_is_clear(const wrap_surface *s, const real A[3], const real B[3])
{
    ends at;
    return !see(s, A, B, &at);
}

int wrap_inside_pull(const wrap_surface *s, const real A[3], const real B[3], pull *out)
{
    ends at;
    real p[3];
    if (!see(s, A, B, &at)) return 0;
    touched_point(&at, s->radius, p);
    pull_through(s, &at, p, out);
    return 1;
}

int wrap_inside_over(const wrap_surface *s, const real A[3], const real B[3], contact *out)
{
    ends at;
    real p[3];
    if (!see(s, A, B, &at)) return 0;
    touched_point(&at, s->radius, p);
    const real share = pull_through(s, &at, p, &out->pull);
    for (int k = 0; k < 3; k++) {
        out->touch[k] = s->centre[k] + p[k] + (at.za + share * (at.zb - at.za)) * s->axis[k];
        out->lift[k] = out->touch[k], out->axis[k] = -at.normal[k];
    }
    return 1;
}
