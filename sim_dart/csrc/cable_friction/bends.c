/* Bends of cables with friction: the angle theta by which a cable turns in each bend, and the sliding
   velocity.

   The spans of a path are in the same order as in paths.c. Let l_k be the sum of the spans from bend k to
   the far end. The cable slides in the bend with l_k', towards the driven end if l_k shortens. So bend_flow
   is A_k = dl_k/dq = L - (spans before the bend), and bend_grip is E_k = mu_k theta_k.

   At a via point, theta is the angle between the directions before and after it. At a surface, theta is the
   angle of contact. On a cylinder on which the cable climbs, theta is multiplied by the cosine of the climb:
   the curvature is that of the circle times the square of the cosine, on an arc that is longer by the
   inverse of the cosine. On an ellipsoid, theta is the integral of the curvature of the geodesic. */
#include "bends.h"

#include "../kinematics/joint_variables.h"
#include "../math/elementary.h"
#include "../paths/ellipsoid/ellipsoid.h"
#include "../paths/place.h"
#include "../paths/span.h"
#include "../optional_parts.h"

#include <string.h>

/* Position of a traversal along a cable. */
typedef struct {
    core *c;
    int32_t muscle, point, bend; /* the next bend */
    int32_t wrap, pulley;
    real *row;    /* derivatives of the traversed spans by all variables */
    real way;     /* length of the traversed spans */
    real last[3]; /* direction of the last span */
} cable_walk;

static real distance(const real A[3], const real B[3])
{
    const real d[3] = {B[0] - A[0], B[1] - A[1], B[2] - A[2]};
    return sqrt(dot3(d, d));
}

static void bend_by(cable_walk *at, real angle)
{
    const size_t dofs = (size_t)at->c->blob.counts.dofs;
    real *flow = at->c->bend_flow + (size_t)at->bend * dofs;
    if (at->c->is_driven) variables_fold(at->c, at->row, flow);
    else memcpy(flow, at->row, dofs * sizeof(real));
    at->c->bend_presliding[at->bend] = at->c->blob.presliding[at->muscle];
    at->c->bend_grip[at->bend] = at->c->blob.bend_friction[at->bend] * angle;
    at->c->bend_behind[at->bend] = larger(at->c->lengths[at->muscle] - at->way, 0);
    at->bend++;
}

/* Return the angle between two directions of any lengths. */
static real angle_between(const real u[3], const real v[3])
{
    real across[3];
    cross3(across, u, v);
    const real s = sqrt(dot3(across, across)), c = dot3(u, v);
    return value_of(s) == 0 && value_of(c) == 0 ? 0 : arc_tangent(s, c);
}

/* Add a span, which begins at a via point or after a contact. */
static void add_span_part(cable_walk *at, const real u[3], const real A[3], int32_t a, const real B[3], int32_t b, real length)
{
    span_add(at->c, u, A, a, B, b, at->row);
    memcpy(at->last, u, sizeof at->last);
    at->way += length;
}

/* Pass an end of a segment. This is a bend, except at the two ends of the cable. */
static void pass_point(cable_walk *at, int32_t first, const real u[3])
{
    if (at->point > first) bend_by(at, angle_between(at->last, u));
}

static void add_straight_segment(cable_walk *at, int32_t first, int32_t contacts)
{
    const int32_t *frame = at->c->blob.point_frame + at->point;
    const real *A = at->c->point + 3 * at->point, *B = A + 3;
    const real length = distance(A, B);
    real u[3];
    for (int k = 0; k < 3; k++) u[k] = value_of(length) > 0 ? (B[k] - A[k]) / length : at->last[k];
    pass_point(at, first, u);
    while (contacts-- > 0) bend_by(at, 0);
    if (value_of(length) > 0) add_span_part(at, u, A, frame[0], B, frame[1], length);
}

/* Square of the radius below which a span is ignored. */
static const real NO_SPAN = PRECISE(1e-12, 1e-8);

/* Compute the direction of a span between a via point and a contact over surface s. If the point lies on the
   surface or within it, the circle shrinks to the point, and the change of length per displacement exceeds
   1. */
static void span_direction(const core *c, int32_t s, const real *point, const real *contact, const real *u, real out[3])
{
    const real *place = c->surface_place + 6 * s, *axis = place + 3;
    real r[3], way[3];
    const wrap_surface placed = placed_surface(c, s);
    for (int k = 0; k < 3; k++) r[k] = point[k] - place[k], way[k] = point[k] - contact[k], out[k] = u[k];
    const real along = c->blob.surface_kind[s] == SURFACE_CYLINDER ? dot3(r, axis) : 0;
    for (int k = 0; k < 3; k++) r[k] -= along * axis[k];
    const real rr = dot3(r, r);
    if (!(value_of(rr) > 0) || value_of(dot3(way, way)) > value_of(NO_SPAN * rr)) return;
    if (USES_ELLIPSOIDS && placed.kind == SURFACE_ELLIPSOID) ellipsoid_normal(&placed, contact, r);
    const real across = dot3(u, r) / dot3(r, r);
    for (int k = 0; k < 3; k++) out[k] -= across * r[k];
}

/* Return the angle by which a cable turns about an axis. */
static real turning_about(const real *contact)
{
    const real *u = contact + 3, *axis = contact + 18;
    const real climb = dot3(u, axis), square = dot3(u, u), level = square - climb * climb;
    return value_of(level) > 0 ? contact[CONTACT_NUMBERS - 1] * sqrt(level / square) : 0;
}

static real turning_over(const core *c, int32_t s, const real *contact)
{
    const wrap_surface placed = placed_surface(c, s);
    const real way = contact[CONTACT_NUMBERS - 1];
    if (!USES_ELLIPSOIDS || placed.kind != SURFACE_ELLIPSOID) return turning_about(contact);
    return value_of(way) > 0 ? ellipsoid_bend(&placed, contact + 12, contact + 3, way) : 0;
}

/* Pass a surface or a pulley with the contact of core_trace. Half the arc is before the bend, as on a circle
   of that radius. */
static void pass_surface(cable_walk *at, const real *contact, real angle, real radius, int32_t *frame, int32_t next)
{
    const real half = 0.5 * radius * contact[CONTACT_NUMBERS - 1];
    add_span_part(at, contact + 3, contact, *frame, contact, next, distance(contact, contact + 12) + half);
    bend_by(at, angle);
    memcpy(at->last, contact + 9, sizeof at->last);
    at->way += half;
    *frame = next;
}

/* Return the radius of the arc. It is 0 for a guide, which the cable touches in a point; the contact with an
   ellipsoid already contains the arc. */
static real arc_radius(const blob_view *blob, int32_t wrap, int32_t s)
{
    if (blob->wrap_side[wrap] == WRAP_INSIDE) return 0;
    return blob->surface_kind[s] == SURFACE_ELLIPSOID ? 1 : blob->surface_radius[s];
}

static void pass_contact(cable_walk *at, int32_t first, int32_t wraps, int32_t pulleys)
{
    core *c = at->c;
    const real *wrap = c->wrap_contact + CONTACT_NUMBERS * at->wrap, *pulley = c->pulley_contact + CONTACT_NUMBERS * at->pulley;
    const real *end = wraps ? wrap + CONTACT_NUMBERS * (wraps - 1) : pulley;
    int32_t frame = c->blob.point_frame[at->point];
    const int32_t *surface = c->blob.wrap_surface + at->wrap;
    real u[3];
    if (pulleys) memcpy(u, pulley + 3, sizeof u);
    else span_direction(c, surface[0], wrap, wrap + 12, wrap + 3, u);
    pass_point(at, first, u);
    if (pulleys)
        pass_surface(at, pulley, turning_about(pulley), c->blob.pulley_radius[at->pulley], &frame, frame);
    for (int32_t w = 0; w < wraps; w++, wrap += CONTACT_NUMBERS) {
        const int32_t s = surface[w];
        const real radius = arc_radius(&c->blob, at->wrap + w, s);
        pass_surface(at, wrap, turning_over(c, s, wrap), radius, &frame, c->blob.surface_frame[s]);
    }
    add_span_part(at, end + 9, end + 6, frame, end + 6, c->blob.point_frame[at->point + 1], distance(end + 15, end + 6));
    if (wraps) span_direction(c, surface[wraps - 1], end + 6, end + 15, end + 9, at->last);
}

static void add_curved_segment_of(cable_walk *at, int32_t first)
{
    const blob_view *blob = &at->c->blob;
    int32_t wraps = 0, touched = 0;
    for (; at->wrap + wraps < blob->counts.wraps && blob->wrap_point[at->wrap + wraps] == at->point; wraps++)
        touched |= value_of(at->c->wrap_contact[CONTACT_NUMBERS * (at->wrap + wraps + 1) - 1]) > 0;
    const int32_t pulleys = at->pulley < blob->counts.pulleys && blob->pulley_point[at->pulley] == at->point;
    if (pulleys) touched |= value_of(at->c->pulley_contact[CONTACT_NUMBERS * (at->pulley + 1) - 1]) > 0;
    if (touched) pass_contact(at, first, wraps, pulleys);
    else add_straight_segment(at, first, wraps + pulleys);
    at->wrap += wraps, at->pulley += pulleys;
}

/* Compute A_k = L - (spans before the bend), in place: bend_flow contains the spans before. */
static void compute_flow(core *c, int32_t muscle, int32_t begin, int32_t end)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    const real *L = c->jacobian + (size_t)muscle * dofs;
    for (real *flow = c->bend_flow + (size_t)begin * dofs; begin < end; begin++, flow += dofs)
        for (size_t j = 0; j < dofs; j++) flow[j] = L[j] - flow[j];
}

void bends_move(core *c)
{
    const blob_view *blob = &c->blob;
    cable_walk at = {.c = c, .row = c->bend_row};
    for (int32_t m = 0, first = 0; m < blob->counts.muscles; first += blob->muscle_points[m++]) {
        const int32_t begin = at.bend, end = first + blob->muscle_points[m];
        if (!blob->muscle_bends[m]) {
            contacts_before(blob, end, &at.wrap, &at.pulley);
            continue;
        }
        memset(at.row, 0, (size_t)blob->counts.variables * sizeof(real));
        memset(at.last, 0, sizeof at.last);
        at.muscle = m, at.way = 0;
        for (at.point = first; at.point < end - 1; at.point++) add_curved_segment_of(&at, first);
        compute_flow(c, m, begin, at.bend);
    }
}
