/* Two tangents and a geodesic between them.

   The tangents from the end a touch the ellipsoid on an ellipse, at the angle alpha (see fan.h); the
   tangents from b, at the angle beta. The geodesic that continues the tangent at alpha reaches, after the
   length s, a point Q with the direction T. The tangent to b begins at P with the direction t. With m
   perpendicular to t on the surface, the cable is taut if

     (Q - P).t = 0,    (Q - P).m = 0,    T.m = 0.

   Newton's method solves this for s, alpha and beta. The derivative of Q and T by alpha is a Jacobi field,
   which is integrated with the geodesic. */
#include "shot.h"

#include "../../math/elementary.h"
#include "../../math/vectors.h"

#include <math.h>
#include <string.h>

/* `sense`: 1 if the cable runs along the tangent, -1 if it runs against it. */
static void find_tangent(const real r[3], const tangent_cone *c, const real end[3], const real angle[2], int sense,
                         tangent_at *out)
{
    real u[3], du[3], n[3];
    for (int k = 0; k < 3; k++) {
        u[k] = r[k] * (angle[0] * c->first[k] + angle[1] * c->second[k] - c->rho * c->at[k]);
        du[k] = r[k] * (angle[0] * c->second[k] - angle[1] * c->first[k]);
    }
    const real size = sqrt(dot3(u, u));
    for (int k = 0; k < 3; k++) {
        out->x[k] = end[k] + c->rho * u[k];
        out->t[k] = sense * u[k] / size;
        n[k] = out->x[k] / (r[k] * r[k]);
    }
    cross3(out->m, n, out->t);
    const real across = sqrt(dot3(out->m, out->m));
    for (int k = 0; k < 3; k++) out->m[k] /= across;
    out->span = c->rho * size;
    out->by_t = c->rho * dot3(du, out->t);
    out->by_m = c->rho * dot3(du, out->m);
    out->turn = sense * dot3(du, out->m) / size;
}

void shot_tangents(const cable_ends *e, shot *s)
{
    find_tangent(e->r, e->cones, e->a, s->way.a, 1, &s->a);
    find_tangent(e->r, e->cones + 1, e->b, s->way.b, -1, &s->b);
}

void shot_follow(const cable_ends *e, real last_term, shot *s)
{
    real missed[3];
    shot_tangents(e, s);
    memcpy(s->end.x, s->a.x, sizeof s->end.x);
    memcpy(s->end.v, s->a.t, sizeof s->end.v);
    s->end.j = s->a.by_m, s->end.dj = s->a.turn;
    geodesic_follow(e->r, s->way.contact, last_term, &s->end, NULL, NULL);
    for (int k = 0; k < 3; k++) missed[k] = s->end.x[k] - s->b.x[k];
    s->gap[0] = dot3(missed, s->b.t), s->gap[1] = dot3(missed, s->b.m), s->gap[2] = dot3(s->end.v, s->b.m);
    s->square = dot3(s->gap, s->gap);
    if (!(value_of(dot3(s->end.v, s->b.t)) > 0)) s->square += 4; /* it comes from the opposite direction */
}

/* Turn a tangent by an angle, approximately. */
static void turn_tangent(real angle[2], real by)
{
    const real t = 0.5 * by, per = 1 / (1 + t * t), c = angle[0], s = angle[1];
    const real cosine_ = (1 - t * t) * per, sine_ = 2 * t * per;
    angle[0] = cosine_ * c - sine_ * s, angle[1] = sine_ * c + cosine_ * s;
}

void shot_move(path_over *way, const real step[3], real part)
{
    turn_tangent(way->a, part * step[0]);
    turn_tangent(way->b, part * step[1]);
    way->contact += part * step[2];
}

real shot_step(const shot *s, real step[3])
{
    const real det = s->end.dj * s->b.by_m - s->end.j * s->b.turn;
    if (det == 0) return INFINITY;
    step[0] = (s->b.turn * s->gap[1] - s->b.by_m * s->gap[2]) / det;
    step[1] = (s->end.dj * s->gap[1] - s->end.j * s->gap[2]) / det;
    step[2] = -s->gap[0] - s->a.by_t * step[0] + s->b.by_t * step[1];
    return value_of(fabs(step[0])) + value_of(fabs(step[1])) + value_of(fabs(step[2]));
}

real shot_length(const shot *s)
{
    return s->a.span + s->way.contact + s->b.span;
}
