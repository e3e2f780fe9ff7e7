/* A cable over one ellipsoid: two tangents and a geodesic between them, found by shooting.

   The tangents from the end a touch the ellipsoid on an ellipse, at the angle alpha (see fan.h); the
   tangents from b, at the angle beta. The geodesic that continues the tangent at alpha reaches, after the
   length s, a point Q with the direction T. The tangent to b begins at P with the direction t. With m
   perpendicular to t on the surface, the cable is taut if

     (Q - P).t = 0,    (Q - P).m = 0,    T.m = 0.

   Newton's method solves this for s, alpha and beta. The derivative of Q and T by alpha is a Jacobi field,
   which is integrated with the geodesic. The search starts at the shortest plane paths (fan.c), at each
   local minimum among neighbouring planes. The shortest solution is selected: the length depends only on the
   ends, not on earlier moves. Its gradient is that of the straight parts (envelope theorem).

   If an end is inside, the ellipsoid shrinks in proportion until its surface passes through the end, as for
   a sphere. The length is then also a function of this scale c. Since it is homogeneous in a, b and c,

     c dl/dc = l - a.dl/da - b.dl/db. */
#include "ellipsoid.h"

#include "../../math/elementary.h"
#include "../../math/vectors.h"
#include "fan.h"
#include "geodesic.h"

#include <math.h>
#include <string.h>

#define MAX_SHOTS 40
#define CONTINUED_SHOTS 8 /* the same from a contact with other ends; if these fail, the search starts again */
#define HALVINGS 6
#define LAST_SHOT_STEP PRECISE(1e-8, 2e-4) /* last step: the remaining error is about its square */
#define ROUNDING_SQUARE PRECISE(1e-24, 1e-10)      /* square of the residual that only rounding errors cause */
#define MAX_TURN 0.5
#define FINE_FROM 1e-3 /* after smaller steps, geodesics are computed up to rounding */
#define FINE_TERM PRECISE(1e-15, 1e-8)
#define ROUGH_TERM PRECISE(1e-9, 1e-7)
#define MIN_CIRCLE 1e-3 /* minimum circle of tangents: on smaller ones angles are undefined */

/* Ends and half axes in the frame of the ellipsoid, divided by its longest half axis. */
typedef struct {
    real R[3][3]; /* its axes in the world */
    real a[3], b[3], r[3], unit;
    real scaled_a[3], scaled_b[3]; /* divided by the half axes */
    int shrunk_by;                 /* 0; 1 or 2: it passes through the end a or b */
    real scale;
    real nearest; /* position on the straight line, 0 to 1, nearest to the centre, scaled */
} ellipsoid_view;

/* Contact point of a tangent: directions of the cable there and their derivatives by the angle. */
typedef struct {
    real x[3], t[3], m[3]; /* point, direction from a to b, perpendicular to it on the surface */
    real span;             /* length from the end */
    real by_t, by_m, turn; /* derivatives: of x along t and m, of t along m */
} tangent_at;

typedef struct {
    path_over way;
    tangent_at a, b;
    geodesic_point end;
    real gap[3], square; /* the three equations; the sum of their squares */
} shot;

/* ------------------------------------------------------------------------------ the ellipsoid and the ends */

/* Compute the view. Return whether the straight line does not meet the ellipsoid. */
static int view_ellipsoid(const wrap_surface *s, const real A[3], const real B[3], ellipsoid_view *v)
{
    const real size[3] = {s->radius, s->half_axes[0], s->half_axes[1]};
    v->unit = larger(larger(size[0], size[1]), size[2]);
    memcpy(v->R[0], s->across, sizeof v->R[0]);
    memcpy(v->R[2], s->axis, sizeof v->R[2]);
    cross3(v->R[1], s->axis, s->across);
    const real a[3] = {A[0] - s->centre[0], A[1] - s->centre[1], A[2] - s->centre[2]};
    const real b[3] = {B[0] - s->centre[0], B[1] - s->centre[1], B[2] - s->centre[2]};
    real aa = 0, ab = 0, bb = 0, x[3];
    for (int k = 0; k < 3; k++) {
        v->r[k] = size[k] / v->unit;
        v->a[k] = dot3(v->R[k], a) / v->unit, v->b[k] = dot3(v->R[k], b) / v->unit;
        v->scaled_a[k] = v->a[k] / v->r[k], v->scaled_b[k] = v->b[k] / v->r[k];
    }
    aa = dot3(v->scaled_a, v->scaled_a), bb = dot3(v->scaled_b, v->scaled_b), ab = dot3(v->scaled_a, v->scaled_b);
    cross3(x, v->scaled_a, v->scaled_b);
    const real inner = smaller(aa, bb), dd = aa + bb - 2 * ab;
    v->nearest = value_of(ab) >= value_of(aa) ? 0 : value_of(ab) >= value_of(bb) ? 1 : (aa - ab) / dd;
    v->shrunk_by = value_of(inner) >= 1 ? 0 : value_of(aa) <= value_of(bb) ? 1 : 2;
    v->scale = v->shrunk_by ? sqrt(inner) : 1;
    const real RR = v->shrunk_by ? inner : 1;
    return value_of(ab) >= value_of(aa) || value_of(ab) >= value_of(bb) || value_of(dot3(x, x)) >= value_of(RR * dd);
}

static void shrink_ellipsoid(ellipsoid_view *v)
{
    if (!v->shrunk_by) return;
    for (int k = 0; k < 3; k++) v->r[k] *= v->scale, v->scaled_a[k] /= v->scale, v->scaled_b[k] /= v->scale;
}

/* ------------------------------------------------------------------------------ shooting */

/* `sense`: 1 if the cable runs along the tangent, -1 if it runs against it. */
static void find_tangent(const ellipsoid_view *v, const tangent_cone *c, const real end[3], const real angle[2], int sense,
                         tangent_at *out)
{
    real u[3], du[3], n[3];
    for (int k = 0; k < 3; k++) {
        u[k] = v->r[k] * (angle[0] * c->first[k] + angle[1] * c->second[k] - c->rho * c->at[k]);
        du[k] = v->r[k] * (angle[0] * c->second[k] - angle[1] * c->first[k]);
    }
    const real size = sqrt(dot3(u, u));
    for (int k = 0; k < 3; k++) {
        out->x[k] = end[k] + c->rho * u[k];
        out->t[k] = sense * u[k] / size;
        n[k] = out->x[k] / (v->r[k] * v->r[k]);
    }
    cross3(out->m, n, out->t);
    const real across = sqrt(dot3(out->m, out->m));
    for (int k = 0; k < 3; k++) out->m[k] /= across;
    out->span = c->rho * size;
    out->by_t = c->rho * dot3(du, out->t);
    out->by_m = c->rho * dot3(du, out->m);
    out->turn = sense * dot3(du, out->m) / size;
}

static void shoot(const ellipsoid_view *v, const tangent_cone cones[2], real last_term, shot *s)
{
    real missed[3];
    find_tangent(v, cones, v->a, s->way.a, 1, &s->a);
    find_tangent(v, cones + 1, v->b, s->way.b, -1, &s->b);
    memcpy(s->end.x, s->a.x, sizeof s->end.x);
    memcpy(s->end.v, s->a.t, sizeof s->end.v);
    s->end.j = s->a.by_m, s->end.dj = s->a.turn;
    geodesic_follow(v->r, s->way.contact, last_term, &s->end, NULL);
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

static void move_way(path_over *way, const real step[3], real part)
{
    turn_tangent(way->a, part * step[0]);
    turn_tangent(way->b, part * step[1]);
    way->contact += part * step[2];
}

/* Compute Newton's step of alpha, beta and s. Return its size. */
static real newton_step(const shot *s, real step[3])
{
    const real det = s->end.dj * s->b.by_m - s->end.j * s->b.turn;
    if (det == 0) return INFINITY;
    step[0] = (s->b.turn * s->gap[1] - s->b.by_m * s->gap[2]) / det;
    step[1] = (s->end.dj * s->gap[1] - s->end.j * s->gap[2]) / det;
    step[2] = -s->gap[0] - s->a.by_t * step[0] + s->b.by_t * step[1];
    return value_of(fabs(step[0])) + value_of(fabs(step[1])) + value_of(fabs(step[2]));
}

/* Iterate, at most that many shots. Each step is shortened until the residual decreases. Return whether it converges. */
static int solve_geodesic(const ellipsoid_view *v, const tangent_cone cones[2], int most, shot *s)
{
    int is_found = 0;
    real last_term = ROUGH_TERM;
    shoot(v, cones, last_term, s);
    for (int shots = 1; shots < most;) {
        real step[3] = {0, 0, 0};
        const real size = newton_step(s, step);
        if (!isfinite(size)) return 0;
        const int is_last = last_term == FINE_TERM && (value_of(size) <= LAST_SHOT_STEP || value_of(s->square) <= ROUNDING_SQUARE);
        if (value_of(size) <= FINE_FROM) last_term = FINE_TERM;
        real part = value_of(size) > MAX_TURN ? MAX_TURN / size : 1;
        shot next = *s;
        for (int halving = 0;; halving++, part *= 0.5) {
            next.way = s->way;
            move_way(&next.way, step, part);
            if (is_last && (!HAS_TANGENT || is_found)) { /* only the end tangents are needed */
                find_tangent(v, cones, v->a, next.way.a, 1, &next.a);
                find_tangent(v, cones + 1, v->b, next.way.b, -1, &next.b);
                *s = next;
                return 1;
            }
            shoot(v, cones, last_term, &next), shots++;
            if (is_last || halving == HALVINGS || value_of(next.square) < value_of(s->square)) break;
        }
        *s = next;
        is_found = is_last;
    }
    return 0;
}

static real whole_length(const shot *s)
{
    return s->a.span + s->way.contact + s->b.span;
}

/* Return whether the contact begins or ends in a half. */
static int is_on_side(const shot *s, int side)
{
    const int k = (side < 0 ? -side : side) - 1, sign = side < 0 ? -1 : 1;
    return !side || value_of(sign * s->a.x[k]) >= 0 || value_of(sign * s->b.x[k]) >= 0;
}

/* Find the shortest solution from starts in a number of planes. Return 0 if a start does not converge. */
static int search_geodesics(const ellipsoid_view *v, const tangent_cone cones[2], int planes, int side, shot *best, int *is_found)
{
    path_over starts[MAX_STARTS];
    const int count = fan_starts(v->r, cones, planes, starts);
    int is_complete = count > 0;
    for (int k = 0; k < count; k++) {
        shot s;
        s.way = starts[k];
        if (!solve_geodesic(v, cones, MAX_SHOTS, &s) || !(value_of(s.way.contact) > 0)) {
            is_complete = 0;
            continue;
        }
        const int rank = is_on_side(&s, side) ? 2 : 1; /* contacts in the half have priority */
        if (rank < *is_found) continue;
        if (rank > *is_found || value_of(whole_length(&s)) < value_of(whole_length(best))) *best = s;
        *is_found = rank;
    }
    return is_complete;
}

/* Use the path in the best plane, which is longer, for the few cases across a long ellipsoid in which
   shooting fails. */
static int use_plane(const ellipsoid_view *v, const tangent_cone cones[2], shot *best)
{
    path_over starts[MAX_STARTS];
    if (!fan_starts(v->r, cones, MANY_PLANES, starts)) return 0;
    best->way = starts[0];
    find_tangent(v, cones, v->a, best->way.a, 1, &best->a);
    find_tangent(v, cones + 1, v->b, best->way.b, -1, &best->b);
    return 1;
}

/* Start from a contact in the world, possibly for other ends. Return 0 if this does not converge. */
static int continue_from(const wrap_surface *s, const ellipsoid_view *v, const tangent_cone cones[2], const contact *from,
                         shot *best)
{
    if (!from || !(value_of(from->pull.angle) > 0)) return 0;
    for (int end = 0; end < 2; end++) {
        const real *p = end ? from->lift : from->touch;
        real y[3], *angle = end ? best->way.b : best->way.a;
        const real at[3] = {p[0] - s->centre[0], p[1] - s->centre[1], p[2] - s->centre[2]};
        for (int k = 0; k < 3; k++) y[k] = dot3(v->R[k], at) / (v->unit * v->r[k]);
        const real c = dot3(y, cones[end].first), sine_ = dot3(y, cones[end].second), size = sqrt(c * c + sine_ * sine_);
        if (!(value_of(size) > MIN_CIRCLE)) return 0;
        angle[0] = c / size, angle[1] = sine_ / size;
    }
    best->way.contact = from->pull.angle / v->unit;
    return solve_geodesic(v, cones, CONTINUED_SHOTS, best) && value_of(best->way.contact) > 0;
}

static int find_geodesic(const wrap_surface *s, const ellipsoid_view *v, const wrap_way *way, shot *best)
{
    const int side = (int)way->side;
    tangent_cone cones[2];
    int is_found = 0;
    fan_cones(v->scaled_a, v->scaled_b, cones);
    if (continue_from(s, v, cones, way->from, best)) return 1;
    if (search_geodesics(v, cones, FEW_PLANES, side, best, &is_found)) return 1;
    search_geodesics(v, cones, MANY_PLANES, side, best, &is_found);
    return is_found || use_plane(v, cones, best);
}

/* ------------------------------------------------------------------------------ pull */

/* Compute the directions, and the contribution of the scale, which is the distance of an end. */
static void compute_directions(const ellipsoid_view *v, const shot *s, pull *out)
{
    real entering[3], leaving[3];
    memcpy(entering, s->a.t, sizeof entering);
    memcpy(leaving, s->b.t, sizeof leaving);
    const real length = whole_length(s);
    if (v->shrunk_by) {
        const real *end = v->shrunk_by == 1 ? v->a : v->b;
        const real rate = (length + dot3(v->a, entering) - dot3(v->b, leaving)) / (v->scale * v->scale);
        for (int k = 0; k < 3; k++) {
            const real r = v->r[k] / v->scale, by_end = rate * end[k] / (r * r);
            if (v->shrunk_by == 1)
                entering[k] -= by_end;
            else
                leaving[k] += by_end;
        }
    }
    out->length = v->unit * length;
    out->angle = v->unit * s->way.contact;
    for (int k = 0; k < 3; k++) {
        out->entering[k] = v->R[0][k] * entering[0] + v->R[1][k] * entering[1] + v->R[2][k] * entering[2];
        out->leaving[k] = v->R[0][k] * leaving[0] + v->R[1][k] * leaving[1] + v->R[2][k] * leaving[2];
    }
}

static int solve_ellipsoid(const wrap_surface *s, const wrap_way *way, const real A[3], const real B[3], ellipsoid_view *v,
                           shot *found)
{
    if (view_ellipsoid(s, A, B, v) || !(value_of(v->scale) > 0)) return 0;
    shrink_ellipsoid(v);
    return find_geodesic(s, v, way, found);
}

int ellipsoid_pull(const wrap_surface *s, const wrap_way *way, const real A[3], const real B[3], pull *out)
{
    ellipsoid_view v;
    shot found;
    if (!solve_ellipsoid(s, way, A, B, &v, &found)) return 0;
    compute_directions(&v, &found, out);
    return 1;
}

int ellipsoid_over(const wrap_surface *s, const wrap_way *way, const real A[3], const real B[3], contact *out)
{
    ellipsoid_view v;
    shot found;
    if (!solve_ellipsoid(s, way, A, B, &v, &found)) return 0;
    compute_directions(&v, &found, &out->pull);
    for (int k = 0; k < 3; k++) {
        out->touch[k] = s->centre[k], out->lift[k] = s->centre[k], out->axis[k] = 0;
        for (int i = 0; i < 3; i++) {
            out->touch[k] += v.unit * v.R[i][k] * found.a.x[i];
            out->lift[k] += v.unit * v.R[i][k] * found.b.x[i];
        }
    }
    return 1;
}

void ellipsoid_normal(const wrap_surface *s, const real touch[3], real normal[3])
{
    ellipsoid_view v;
    view_ellipsoid(s, touch, touch, &v);
    memset(normal, 0, 3 * sizeof *normal);
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) normal[i] += v.a[k] / (v.r[k] * v.r[k]) * v.R[k][i];
}

real ellipsoid_bend(const wrap_surface *s, const real touch[3], const real direction[3], real way)
{
    ellipsoid_view v;
    geodesic_point p = {.j = 0};
    real n[3], bend = 0;
    view_ellipsoid(s, touch, touch, &v);
    ellipsoid_normal(s, touch, n);
    const real off = dot3(direction, n) / dot3(n, n), scale = sqrt(dot3(v.scaled_a, v.scaled_a));
    for (int k = 0; k < 3; k++) n[k] = direction[k] - off * n[k];
    const real size = sqrt(dot3(n, n));
    for (int k = 0; k < 3; k++) {
        p.x[k] = v.a[k], p.v[k] = dot3(v.R[k], n) / size;
        v.r[k] *= scale; /* an end inside shrinks the ellipsoid */
    }
    geodesic_follow(v.r, way / v.unit, FINE_TERM, &p, &bend);
    return bend;
}

int ellipsoid_is_clear(const wrap_surface *s, const real A[3], const real B[3])
{
    ellipsoid_view v;
    return view_ellipsoid(s, A, B, &v);
}

real ellipsoid_nearest(const wrap_surface *s, const real A[3], const real B[3])
{
    ellipsoid_view v;
    view_ellipsoid(s, A, B, &v);
    return v.nearest;
}

int ellipsoid_holds(const wrap_surface *s, const real A[3], const real B[3])
{
    ellipsoid_view v;
    view_ellipsoid(s, A, B, &v);
    return v.shrunk_by != 0;
}

int ellipsoid_side(const wrap_surface *s, const real direction[3])
{
    real y[3];
    cross3(y, s->axis, s->across);
    const real at[3] = {dot3(s->across, direction), dot3(y, direction), dot3(s->axis, direction)};
    int maximum = 0;
    for (int k = 1; k < 3; k++)
        if (value_of(fabs(at[k])) > value_of(fabs(at[maximum]))) maximum = k;
    return value_of(at[maximum]) < 0 ? -1 - maximum : 1 + maximum;
}
