/* A cable over one ellipsoid: two tangents and a geodesic between them (shot.c), found by a search among plane
   paths (taut_search.c). The gradient of the length is that of the straight parts (envelope theorem).

   If an end is inside, the ellipsoid shrinks in proportion until its surface passes through the end, as for
   a sphere. The length is then also a function of this scale c. Since it is homogeneous in a, b and c,

     c dl/dc = l - a.dl/da - b.dl/db.

   Derivatives need no search. At the found contact, the implicit function theorem determines the changes of
   the contact from those of the three equations. If the ellipsoid does not change, these follow from the Jacobi
   fields of the geodesic, which do not depend on the direction of the derivative. */
#include "ellipsoid.h"

#include "../../blob/state.h"
#include "../../math/elementary.h"
#include "../../math/vectors.h"
#include "geodesic.h"
#include "shot.h"
#include "taut_search.h"

#include <math.h>
#include <string.h>

/* Derivatives use the result of the plain core, whose ends differ by rounding. */
#define SAME_ENDS (HAS_TANGENT ? 1e-13 : 0)
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

/* ------------------------------------------------------------------------------ contact */

/* Numbers that are stored for a wrap: ends, half axes and side of the last search, its answer and way, and the
   Jacobi fields, which are NAN before they are computed. */
enum { KEY_NUMBERS = 10, ANSWER = KEY_NUMBERS, WAY, FIELDS = WAY + WAY_NUMBERS };
typedef char stored_numbers_fit[FIELDS + 4 == PATH_NUMBERS ? 1 : -1];

/* Convert a contact in the world, possibly for other ends, to a way. Return 0 if this is impossible. */
static int way_of(const wrap_surface *s, const ellipsoid_view *v, const tangent_cone cones[2], const contact *from,
                  plain_real way[WAY_NUMBERS])
{
    if (!from || !(value_of(from->pull.angle) > 0)) return 0;
    for (int end = 0; end < 2; end++) {
        const real *p = end ? from->lift : from->touch;
        const real at[3] = {p[0] - s->centre[0], p[1] - s->centre[1], p[2] - s->centre[2]};
        real y[3];
        for (int k = 0; k < 3; k++) y[k] = dot3(v->R[k], at) / (v->unit * v->r[k]);
        const real c = dot3(y, cones[end].first), sine_ = dot3(y, cones[end].second), size = sqrt(c * c + sine_ * sine_);
        if (!(value_of(size) > MIN_CIRCLE)) return 0;
        way[2 * end] = value_of(c / size), way[2 * end + 1] = value_of(sine_ / size);
    }
    way[4] = value_of(from->pull.angle / v->unit);
    return 1;
}

static void set_task(const wrap_surface *s, const ellipsoid_view *v, const tangent_cone cones[2], const wrap_way *way,
                     taut_task *task)
{
    for (int k = 0; k < 3; k++) {
        task->r[k] = value_of(v->r[k]);
        task->ends[0][k] = value_of(v->a[k]), task->ends[1][k] = value_of(v->b[k]);
        task->scaled[0][k] = value_of(v->scaled_a[k]), task->scaled[1][k] = value_of(v->scaled_b[k]);
    }
    task->side = way->side;
    memset(task->from, 0, sizeof task->from);
    task->is_continued = way_of(s, v, cones, way->from, task->from);
}

/* Search, or use the stored result for the same numbers, which are replaced. */
static enum taut_answer search(const taut_task *task, real *stored)
{
    plain_real way[WAY_NUMBERS], key[KEY_NUMBERS];
    memcpy(key, task->scaled, sizeof task->scaled);
    memcpy(key + 6, task->r, sizeof task->r);
    key[9] = (plain_real)task->side;
    int is_same = !task->is_continued;
    for (int k = 0; k < KEY_NUMBERS; k++) is_same = is_same && value_of(fabs(stored[k] - key[k])) <= SAME_ENDS;
    if (is_same) return (enum taut_answer)value_of(stored[ANSWER]);
    const enum taut_answer answer = taut_search(task, way);
    for (int k = 0; k < KEY_NUMBERS; k++) stored[k] = task->is_continued ? NAN : key[k];
    for (int k = 0; k < WAY_NUMBERS && answer; k++) stored[WAY + k] = way[k];
    stored[ANSWER] = answer, stored[FIELDS] = NAN;
    return answer;
}

#if HAS_TANGENT

static real change_of(real x)
{
    return with_tangent(0, tangent_of(x));
}

static real change_along(const real u[3], const real v[3])
{
    real sum = 0;
    for (int k = 0; k < 3; k++) sum += change_of(u[k]) * value_of(v[k]);
    return sum;
}

/* Compute the changes of the three equations of a solution, for a constant way and a constant ellipsoid. */
static void change_equations(const taut_task *task, real *stored, shot *s)
{
    plain_real way[WAY_NUMBERS], fields[4];
    if (!is_not_a_number(stored[FIELDS])) {
        for (int k = 0; k < 4; k++) fields[k] = value_of(stored[FIELDS + k]);
    } else {
        for (int k = 0; k < WAY_NUMBERS; k++) way[k] = value_of(stored[WAY + k]);
        taut_fields(task, way, fields);
        for (int k = 0; k < 4; k++) stored[FIELDS + k] = fields[k];
    }
    const real off = change_along(s->a.x, s->a.m), turn = change_along(s->a.t, s->a.m);
    s->end.j = s->a.by_m * fields[0] + s->a.turn * fields[2];
    s->end.dj = s->a.by_m * fields[1] + s->a.turn * fields[3];
    s->gap[0] = change_along(s->a.x, s->a.t) - change_along(s->b.x, s->b.t);
    s->gap[1] = off * fields[0] + turn * fields[2] - change_along(s->b.x, s->b.m);
    s->gap[2] = off * fields[1] + turn * fields[3] - change_along(s->b.t, s->b.m);
}

/* Add the changes of a solution. */
static void change_contact(const cable_ends *e, const taut_task *task, real *stored, shot *s)
{
    real step[3] = {0, 0, 0};
    const int is_constant = tangent_of(e->r[0]) == 0 && tangent_of(e->r[1]) == 0 && tangent_of(e->r[2]) == 0;
    if (is_constant)
        change_equations(task, stored, s);
    else
        shot_follow(e, FINE_TERM, s);
    if (!isfinite(shot_step(s, step))) return;
    shot_move(&s->way, step, 1);
    shot_tangents(e, s);
}

#endif

static int find_geodesic(const wrap_surface *s, const ellipsoid_view *v, const wrap_way *way, shot *best)
{
    real local[PATH_NUMBERS] = {NAN}, *stored = s->stored ? s->stored : local;
    taut_task task;
    cable_ends e;
    memcpy(e.r, v->r, sizeof e.r), memcpy(e.a, v->a, sizeof e.a), memcpy(e.b, v->b, sizeof e.b);
    fan_cones(v->scaled_a, v->scaled_b, e.cones);
    set_task(s, v, e.cones, way, &task);
    const enum taut_answer answer = search(&task, stored);
    if (answer == TAUT_NONE) return 0;
    memcpy(best->way.a, stored + WAY, sizeof best->way.a);
    memcpy(best->way.b, stored + WAY + 2, sizeof best->way.b);
    best->way.contact = stored[WAY + 4];
    shot_tangents(&e, best);
#if HAS_TANGENT
    if (answer == TAUT_PATH) change_contact(&e, &task, stored, best);
#endif
    return 1;
}

/* ------------------------------------------------------------------------------ pull */

/* Compute the directions, and the contribution of the scale, which is the distance of an end. */
static void compute_directions(const ellipsoid_view *v, const shot *s, pull *out)
{
    real entering[3], leaving[3];
    memcpy(entering, s->a.t, sizeof entering);
    memcpy(leaving, s->b.t, sizeof leaving);
    const real length = shot_length(s);
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
    geodesic_follow(v.r, way / v.unit, FINE_TERM, &p, NULL, &bend);
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
