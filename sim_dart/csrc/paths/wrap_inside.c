/* A cable inside a sphere or a cylinder: the surface is a hole through which the cable runs.

   Seen along the axis (of the plane through both ends and the centre, for a sphere) a straight line that
   passes through the circle, or ends in it, is free. Otherwise the cable touches the circle from within at
   the point p with minimal |a - p| + |p - b|: both parts have the same angle to the radius there. With p
   turned by the angle z from a towards b, which is at the angle G, the difference of these angles is zero if

     sin(2 z - G) - R/|b| sin z + R/|a| sin(G - z) = 0,

   which has one solution among the points visible from both ends. On a cylinder the cable climbs at a
   constant slope along that planar path, as outside. Contact begins smoothly. The motion of the contact
   point does not contribute to the gradient, as p minimises the length. */
#include "wrap_inside.h"

#include "../blob/layout.h"
#include "../math/elementary.h"
#include "../math/root.h"
#include "../math/vectors.h"

#include <math.h>

/* Last step of Newton's method, in [rad]: the remaining error is about its square. */
#define LAST_WRAP_STEP PRECISE(1e-8, 1e-4)

typedef struct {
    real a[3], b[3], za, zb; /* the ends perpendicular to the axis and along it */
    real ra, rb;             /* their distances */
    real cosine, sine;       /* of the angle G between them */
    real normal[3];          /* axis about which the angle is positive */
} ends;

/* Return whether the cable touches; compute `at` if it does. */
static int find_contact(const wrap_surface *s, const real A[3], const real B[3], ends *at)
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
    at->ra = sqrt(aa), at->rb = sqrt(bb);
    const real per_both = 1 / (at->ra * at->rb);
    at->cosine = per_both * (aa + ad), at->sine = per_both * cross;
    for (int k = 0; k < 3; k++) at->normal[k] = value_of(cross) > 0 ? x[k] / cross : 0;
    return 1;
}

typedef struct {
    real G, by_a, by_b; /* R/|a|, R/|b| */
} mirror;

static real mirror_residual(const void *data, real z, real *derivative)
{
    const mirror *m = data;
    real sine_z, cosine_z, sine_rest, cosine_rest;
    sine_cosine(z, &sine_z, &cosine_z);
    sine_cosine(m->G - z, &sine_rest, &cosine_rest);
    *derivative = 2 * (cosine_z * cosine_rest + sine_z * sine_rest) - m->by_b * cosine_z - m->by_a * cosine_rest;
    return sine_z * cosine_rest - cosine_z * sine_rest - m->by_b * sine_z + m->by_a * sine_rest;
}

/* Return the angle from a to the contact. It is limited by the tangents of both ends. */
static real contact_angle_inside(const ends *at, real by_a, real by_b)
{
    const mirror m = {arc_tangent(at->sine, at->cosine), by_a, by_b};
    const real seen_a = arc_cosine(by_a), seen_b = arc_cosine(by_b);
    const real low = larger(0, m.G - seen_b), high = larger(low, smaller(m.G, seen_a));
    const real guess = m.G * (1 - by_a) / ((1 - by_a) + (1 - by_b));
    return bracketed_root(mirror_residual, &m, low, high, smaller(larger(guess, low), high), LAST_WRAP_STEP);
}

#define QUICK_STEPS 8
/* One more step follows: its error is about the square of the square of this one, in [rad]. */
#define QUICK_TOLERANCE (HAS_TANGENT ? LAST_WRAP_STEP : PRECISE(1e-5, 1e-3))

/* Compute cosine and sine of this angle by Newton's method for the unit vector (c, s), which needs no angles.
   Return 0 if it does not converge to a point that is visible from both ends. */
static int quick_contact(const ends *at, real by_a, real by_b, real *cosine, real *sine)
{
    real c = (1 - by_b) + (1 - by_a) * at->cosine, s = (1 - by_a) * at->sine, last = 1;
    const real per = 1 / sqrt(c * c + s * s);
    c *= per, s *= per;
    for (int i = 0, is_last = 0; i < QUICK_STEPS; i++) {
        const real rest_c = at->cosine * c + at->sine * s, rest_s = at->sine * c - at->cosine * s;
        const real slope = 2 * (c * rest_c + s * rest_s) - by_b * c - by_a * rest_c;
        const real step = (c * rest_s - s * rest_c + by_b * s - by_a * rest_s) / slope;
        if (!(value_of(slope) > 0 && value_of(fabs(step)) < value_of(last))) return 0;
        const int is_seen = value_of(c) >= value_of(by_a) && value_of(rest_c) >= value_of(by_b);
        const real level = 1 - 0.5 * step * step, next_c = level * c - step * s, next_s = level * s + step * c;
        const real scale = 1.5 - 0.5 * (next_c * next_c + next_s * next_s); /* one over the norm, which is about 1 */
        *cosine = c = scale * next_c, *sine = s = scale * next_s, last = fabs(step);
        if (is_last) return is_seen && value_of(s) >= 0 && value_of(rest_s) >= 0;
        is_last = value_of(fabs(step)) <= value_of(QUICK_TOLERANCE);
        last = is_last ? 1 : last / 2;
    }
    return 0;
}

/* Compute the contact point relative to the centre, perpendicular to the axis: R (cos z a + sin z n x a) /
   |a|. */
static void contact_point_inside(const ends *at, real R, real p[3])
{
    real s, c, across[3];
    const real by_a = R / at->ra, by_b = R / at->rb;
    if (!quick_contact(at, by_a, by_b, &c, &s)) sine_cosine(contact_angle_inside(at, by_a, by_b), &s, &c);
    cross3(across, at->normal, at->a);
    for (int k = 0; k < 3; k++) p[k] = by_a * (c * at->a[k] + s * across[k]);
}

/* The parts before and after p have their directions in the plane and the same slope along the axis. Return
   the share of the first part of the length. */
static real pull_through(const wrap_surface *s, const ends *at, const real p[3], pull *out)
{
    real u[3], v[3];
    for (int k = 0; k < 3; k++) u[k] = p[k] - at->a[k], v[k] = at->b[k] - p[k];
    const real before = sqrt(dot3(u, u)), after = sqrt(dot3(v, v)), P = before + after, h = at->zb - at->za;
    out->length = sqrt(P * P + h * h);
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
    return !find_contact(s, A, B, &at);
}

int wrap_inside_pull(const wrap_surface *s, const real A[3], const real B[3], pull *out)
{
    ends at;
    real p[3];
    if (!find_contact(s, A, B, &at)) return 0;
    contact_point_inside(&at, s->radius, p);
    pull_through(s, &at, p, out);
    return 1;
}

int wrap_inside_over(const wrap_surface *s, const real A[3], const real B[3], contact *out)
{
    ends at;
    real p[3], u[3], v[3], turn[3];
    if (!find_contact(s, A, B, &at)) return 0;
    contact_point_inside(&at, s->radius, p);
    for (int k = 0; k < 3; k++) u[k] = p[k] - at.a[k], v[k] = at.b[k] - p[k];
    cross3(turn, u, v);
    out->pull.angle = arc_tangent(sqrt(dot3(turn, turn)), dot3(u, v));
    const real share = pull_through(s, &at, p, &out->pull);
    for (int k = 0; k < 3; k++) {
        out->touch[k] = s->centre[k] + p[k] + (at.za + share * (at.zb - at.za)) * s->axis[k];
        out->lift[k] = out->touch[k], out->axis[k] = -at.normal[k];
    }
    return 1;
}
