/* The rules of MuJoCo and of OpenSim: for cylinders in the plane perpendicular to the axis, for spheres in
   the plane through both ends and the centre. There are two paths, one for each sense of turning. On each of
   them the cable is shortest, in closed form (wrap.c). As in these programs, the cable is straight if an end
   is inside, and its length jumps when the path changes. */
#include "wrap_rules.h"

#include "../../blob/layout.h"
#include "../../math/elementary.h"
#include "../../math/vectors.h"
#include "../../optional_parts.h"
#include "../ellipsoid/ellipsoid.h"

#include <math.h>
#include <stddef.h>

#define MIN_SQUARE 1e-15

/* The ends in the plane, and their tangents. */
typedef struct {
    real a[3], b[3], d[3], n[3]; /* ends relative to the centre, b - a, normal of the plane */
    real za, zb;                 /* along a cylinder's axis */
    real aa, bb, dd, RR, R, t;   /* t: position on the infinite line nearest to the centre */
    real near[3];                /* nearest point */
} flat;

static int flatten(const wrap_surface *s, const real A[3], const real B[3], flat *f)
{
    const int is_cylinder = s->kind == SURFACE_CYLINDER;
    for (int k = 0; k < 3; k++) f->a[k] = A[k] - s->centre[k], f->b[k] = B[k] - s->centre[k], f->n[k] = s->axis[k];
    f->za = f->zb = 0;
    if (is_cylinder) {
        f->za = dot3(f->a, f->n), f->zb = dot3(f->b, f->n);
        for (int k = 0; k < 3; k++) f->a[k] -= f->za * f->n[k], f->b[k] -= f->zb * f->n[k];
    } else {
        real x[3];
        cross3(x, f->a, f->b);
        const real xx = dot3(x, x), per = value_of(xx) > 0 ? 1 / sqrt(xx) : 0;
        for (int k = 0; k < 3; k++) f->n[k] = per * x[k];
        if (!(value_of(xx) > 0)) unit_across(f->n, f->a);
    }
    for (int k = 0; k < 3; k++) f->d[k] = f->b[k] - f->a[k];
    f->R = s->radius, f->RR = f->R * f->R;
    f->aa = dot3(f->a, f->a), f->bb = dot3(f->b, f->b), f->dd = dot3(f->d, f->d);
    f->t = value_of(f->dd) > MIN_SQUARE * MIN_SQUARE ? -dot3(f->a, f->d) / f->dd : 0;
    for (int k = 0; k < 3; k++) f->near[k] = f->a[k] + f->t * f->d[k];
    return value_of(f->aa) >= value_of(f->RR) && value_of(f->bb) >= value_of(f->RR);
}

/* Compute the contact begin and end for a sense of turning about n. */
static void tangents(const flat *f, int sense, real touch[3], real lift[3])
{
    const real ta = sqrt(f->aa - f->RR), tb = sqrt(f->bb - f->RR);
    real across[3];
    cross3(across, f->n, f->a);
    for (int k = 0; k < 3; k++) touch[k] = (f->RR * f->a[k] + sense * f->R * ta * across[k]) / f->aa;
    cross3(across, f->n, f->b);
    for (int k = 0; k < 3; k++) lift[k] = (f->RR * f->b[k] - sense * f->R * tb * across[k]) / f->bb;
}

/* Return the angle from u to v about n. */
static real turned(const flat *f, const real u[3], const real v[3])
{
    real x[3];
    cross3(x, u, v);
    return dot3(x, f->n);
}

/* Return whether the two straight parts cross. */
static int is_crossing(const flat *f, int sense)
{
    real touch[3], lift[3], u[3], v[3], w[3];
    tangents(f, sense, touch, lift);
    for (int k = 0; k < 3; k++) u[k] = touch[k] - f->a[k], v[k] = lift[k] - f->b[k], w[k] = f->b[k] - f->a[k];
    const real det = turned(f, u, v);
    if (value_of(fabs(det)) < MIN_SQUARE) return 0;
    const real s = turned(f, w, v) / det, t = turned(f, w, u) / det;
    return value_of(s) >= 0 && value_of(s) <= 1 && value_of(t) >= 0 && value_of(t) <= 1;
}

/* Return whether a direction lies between the directions opposite to the ends, where the longer path passes. */
static int is_opposite(const flat *f, const real side[3])
{
    const real from = -turned(f, f->a, side), to = -turned(f, side, f->b);
    const int natural = value_of(turned(f, f->a, f->b)) >= 0 ? 1 : -1;
    return value_of(from * natural) >= 0 && value_of(to * natural) >= 0;
}

static int mujoco_rule(const wrap_surface *s, const flat *f, const real *guide, wrap_way *way)
{
    real side[3];
    for (int k = 0; k < 3 && guide; k++) side[k] = guide[k] - s->centre[k];
    if (guide) {
        if (value_of(dot3(side, side)) < value_of(f->RR)) { /* also along the axis of a cylinder */
            way->side = WRAP_INSIDE;
            return RULE_WRAPS; /* or straight: see wrap_inside.c */
        }
        const real along = dot3(side, f->n);
        for (int k = 0; k < 3; k++) side[k] -= along * f->n[k];
    }
    if (value_of(f->dd) < MIN_SQUARE) return RULE_STRAIGHT;
    const real t = value_of(f->t) < 0 ? 0 : value_of(f->t) > 1 ? 1 : f->t;
    real near[3];
    for (int k = 0; k < 3; k++) near[k] = f->a[k] + t * f->d[k];
    const int is_clear = value_of(dot3(near, near)) > value_of(f->RR);
    if (is_clear && (!guide || value_of(dot3(side, near)) >= 0)) return RULE_STRAIGHT;
    const int natural = value_of(turned(f, f->a, f->b)) >= 0 ? 1 : -1;
    way->side = guide && is_opposite(f, side) ? -natural : natural;
    if (!is_clear) return RULE_WRAPS; /* neither path crosses itself, and the natural one has the shorter chord */
    return is_crossing(f, way->side) ? RULE_STRAIGHT : RULE_WRAPS;
}

/* Return whether a point at that height is in the quadrant. */
static int is_on(const flat *f, const real *guide, const real p[3], real z)
{
    return value_of(dot3(p, guide) + z * dot3(f->n, guide)) >= 0;
}

/* Apply OpenSim's choice of two of the four tangent points, for a cylinder. */
static int sense_in_quadrant(const flat *f, const real *guide)
{
    real ra[3], sa[3], rb[3], sb[3]; /* contact begin and end, for each sense */
    tangents(f, 1, ra, sb);
    tangents(f, -1, rb, sa);
    const int is_ra = is_on(f, guide, ra, f->za), is_rb = is_on(f, guide, rb, f->za);
    const int is_sa = is_on(f, guide, sa, f->zb), is_sb = is_on(f, guide, sb, f->zb);
    if (is_ra != is_rb) return is_ra ? 1 : -1;
    if (is_sa) return -1;
    if (is_ra || is_sb) return 1;
    return value_of(dot3(ra, sb)) < value_of(dot3(rb, sa)) ? 1 : -1; /* by the larger angle */
}

/* Return whether a cylinder is touched only beyond its ends. */
static int is_beyond(const wrap_surface *s, const flat *f, int sense)
{
    if (!(value_of(s->half) > 0)) return 0;
    real touch[3], lift[3];
    tangents(f, sense, touch, lift);
    const real ta = sqrt(f->aa - f->RR), tb = sqrt(f->bb - f->RR);
    const real arc = arc_tangent(sense * turned(f, touch, lift), dot3(touch, lift));
    const real P = ta + tb + f->R * (value_of(arc) < 0 ? arc + 2 * PI : arc), h = f->zb - f->za;
    const real from = f->za + h * ta / P, to = f->zb - h * tb / P;
    return value_of(fabs(from)) > value_of(s->half) && value_of(fabs(to)) > value_of(s->half);
}

static int opensim_rule(const wrap_surface *s, const flat *f, const real *guide, wrap_way *way)
{
    const int is_met = value_of(dot3(f->near, f->near)) < value_of(f->RR) && value_of(f->t) > 0 && value_of(f->t) < 1;
    const int natural = value_of(turned(f, f->a, f->b)) >= 0 ? 1 : -1;
    const int is_sphere = s->kind != SURFACE_CYLINDER;
    if (is_sphere || !guide) {
        if (!is_met) return RULE_STRAIGHT;
        way->side = natural;
        if (guide && value_of(dot3(f->near, guide)) < 0) way->side = -natural;
        if (!is_sphere) return is_beyond(s, f, way->side) ? RULE_STRAIGHT : RULE_MEETS;
        return guide && (is_on(f, guide, f->a, f->za) || is_on(f, guide, f->b, f->zb)) ? RULE_MEETS : RULE_WRAPS;
    }
    const int is_a = is_on(f, guide, f->a, f->za), is_b = is_on(f, guide, f->b, f->zb);
    const int is_passed = is_a != is_b && !is_on(f, guide, f->near, f->za + f->t * (f->zb - f->za));
    if ((is_a || is_b) && !is_met && !is_passed) return RULE_STRAIGHT;
    way->side = sense_in_quadrant(f, guide);
    if (is_beyond(s, f, way->side)) return RULE_STRAIGHT;
    return is_met && (is_a || is_b) ? RULE_MEETS : RULE_WRAPS;
}

/* Apply OpenSim's rule: if the straight line meets the ellipsoid, the path is the shortest of those that
   touch it in the quadrant. */
static int ellipsoid_rule(const wrap_surface *s, const real *guide, const real A[3], const real B[3], wrap_way *way)
{
    if (ellipsoid_holds(s, A, B) || ellipsoid_is_clear(s, A, B)) return RULE_STRAIGHT;
    way->side = guide ? ellipsoid_side(s, guide) : 0;
    return RULE_MEETS;
}

int wrap_rule(int32_t rule, const wrap_surface *s, const real *guide, const real A[3], const real B[3],
              wrap_way *way)
{
    if (USES_ELLIPSOIDS && s->kind == SURFACE_ELLIPSOID) return ellipsoid_rule(s, guide, A, B, way);
    flat f;
    const int is_outside = flatten(s, A, B, &f);
    way->is_forced = 1, way->side = 0;
    if (!is_outside) return RULE_STRAIGHT;
    return rule == RULE_MUJOCO ? mujoco_rule(s, &f, guide, way) : opensim_rule(s, &f, guide, way);
}
