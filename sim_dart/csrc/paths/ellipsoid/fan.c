/* A fan of planes through both ends of a cable: in each plane the cable is taut over an ellipse.

   After scaling by its half axes, the ellipsoid is the unit sphere, and planes and tangents are preserved.
   The ellipse becomes a circle: tangents are in closed form, the length of the arc is approximated by
   chords. The shortest of these plane paths is close to the shortest path. */
#include "fan.h"

#include "../../math/elementary.h"
#include "../../math/vectors.h"

#include <math.h>
#include <string.h>

#define CHORDS 4 /* number of chords, a power of 2 */
#define LONGER 1.2 /* relative length above which paths are ignored */

/* cos(2 pi k / MANY_PLANES) */
static const real PLANE_COSINE[MANY_PLANES / 4 + 1] = {
    1, 0.9951847266721969, 0.9807852804032304, 0.9569403357322088, 0.9238795325112867, 0.881921264348355,
    0.8314696123025452, 0.773010453362737, 0.7071067811865476, 0.6343932841636455, 0.5555702330196023,
    0.4713967368259978, 0.38268343236508984, 0.29028467725446233, 0.19509032201612833, 0.09801714032956077, 0};

typedef struct {
    path_over way;
    real length;
} plane_path;

static void set_cone(const real at[3], const real other[3], tangent_cone *c)
{
    memcpy(c->at, at, sizeof c->at);
    c->distance2 = dot3(at, at);
    const real over = larger(c->distance2 - 1, 0);
    c->reach = sqrt(over);
    c->rho = sqrt(over / c->distance2);
    real across[3];
    cross3(across, at, other);
    const real square = dot3(across, across), per = value_of(square) > 0 ? 1 / sqrt(square) : 0;
    for (int k = 0; k < 3; k++) c->second[k] = per * across[k];
    if (!(value_of(square) > 0)) unit_across(c->second, at);
    cross3(c->first, c->second, at);
    c->distance = sqrt(c->distance2);
    for (int k = 0; k < 3; k++) c->first[k] /= c->distance;
}

void fan_cones(const real a[3], const real b[3], tangent_cone cones[2])
{
    set_cone(a, b, cones);
    set_cone(b, a, cones + 1);
}

static real scaled_norm(const real r[3], const real v[3])
{
    const real w[3] = {r[0] * v[0], r[1] * v[1], r[2] * v[2]};
    return sqrt(dot3(w, w));
}

/* Turn v about the unit vector N, which is perpendicular to it. */
static void turn_about(const real N[3], real cosine_, real sine_, const real v[3], real out[3])
{
    real across[3];
    cross3(across, N, v);
    for (int k = 0; k < 3; k++) out[k] = cosine_ * v[k] + sine_ * across[k];
}

/* Return the length of the arc from p, turned about N by an angle from 0 to 2 pi. */
static real arc_length(const real r[3], const real N[3], real cosine_, real sine_, const real p[3])
{
    int is_upper = value_of(sine_) < 0; /* more than half a turn */
    for (int parts = CHORDS; parts > 1; parts /= 2) {
        sine_ = sqrt(larger(0.5 * (1 - cosine_), 0));
        cosine_ = (is_upper ? -1 : 1) * sqrt(larger(0.5 * (1 + cosine_), 0));
        is_upper = 0;
    }
    real from[3], to[3], length = 0;
    memcpy(from, p, sizeof from);
    for (int part = 0; part < CHORDS; part++) {
        turn_about(N, cosine_, sine_, from, to);
        const real chord[3] = {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
        length += scaled_norm(r, chord);
        memcpy(from, to, sizeof from);
    }
    const real half2 = 0.5 * (1 - cosine_); /* square of the sine of half a part: ratio of arc and chord */
    return length * (1 + half2 * (1.0 / 6 + half2 * (3.0 / 40)));
}

/* Compute the path in the plane of the tangent from a with that cosine and sine. Return 0 if the plane does
   not contain a path. */
static int section(const real r[3], const tangent_cone cones[2], real cosine_, real sine_, plane_path *out)
{
    const tangent_cone *A = cones, *B = cones + 1;
    const real per_a = 1 / A->distance;
    real along[3], chord[3], N[3], p[3], q[3], b[3], leaving[3];
    for (int k = 0; k < 3; k++) {
        along[k] = per_a * (cosine_ * A->first[k] + sine_ * A->second[k] - A->rho * A->at[k]);
        chord[k] = B->at[k] - A->at[k];
    }
    cross3(N, along, chord);
    const real NN = dot3(N, N);
    if (!(value_of(NN) > 0)) return 0;
    const real per = 1 / sqrt(NN), h = per * dot3(N, A->at), RR = 1 - h * h, R = sqrt(larger(RR, 0));
    if (!(value_of(RR) > 0)) return 0;
    for (int k = 0; k < 3; k++) {
        N[k] *= per;
        p[k] = A->at[k] + A->reach * along[k] - h * N[k], b[k] = B->at[k] - h * N[k];
    }
    const real bb = dot3(b, b);
    turn_about(N, RR / bb, -R * B->reach / bb, b, q);
    cross3(leaving, N, q);
    real turned[3], square = 0;
    cross3(turned, p, q);
    const real cosine_arc = dot3(p, q) / RR, sine_arc = dot3(turned, N) / RR;
    for (int k = 0; k < 3; k++) {
        leaving[k] /= R;
        turned[k] = B->rho * B->at[k] - B->distance * leaving[k]; /* cos t e1 + sin t e2 */
        square += turned[k] * turned[k];
    }
    const real per_turned = value_of(square) > 0 ? 1 / sqrt(square) : 0;
    out->way.a[0] = cosine_, out->way.a[1] = sine_;
    out->way.b[0] = per_turned * dot3(turned, B->first), out->way.b[1] = per_turned * dot3(turned, B->second);
    out->way.contact = arc_length(r, N, cosine_arc, sine_arc, p);
    out->length = out->way.contact + A->reach * scaled_norm(r, along) + B->reach * scaled_norm(r, leaving);
    return 1;
}

/* Compute the angle of plane k. */
static void plane_angle(int k, int planes, real *cosine_, real *sine_)
{
    const int quarter = MANY_PLANES / 4, at = k * (MANY_PLANES / planes), part = at % quarter;
    const real c = PLANE_COSINE[part], s = PLANE_COSINE[quarter - part];
    const int turned = at / quarter;
    *cosine_ = turned == 0 ? c : turned == 1 ? -s : turned == 2 ? -c : s;
    *sine_ = turned == 0 ? s : turned == 1 ? c : turned == 2 ? -s : -c;
}

/* Move to the vertex of the parabola through the lengths in three planes, which are `step` apart. */
static void refine(const real r[3], const tangent_cone cones[2], real step, real before,
                   real after, plane_path *way)
{
    const real bend = before + after - 2 * way->length;
    if (bend == 0) return;
    const real t = 0.25 * step * (before - after) / bend; /* tangent of half the angle, approximately */
    const real c = (1 - t * t) / (1 + t * t), s = 2 * t / (1 + t * t);
    const real ck = way->way.a[0], sk = way->way.a[1];
    plane_path refined;
    if (section(r, cones, c * ck - s * sk, c * sk + s * ck, &refined)) *way = refined;
}

/* Insert a path into the found ones, sorted by length. Return their number. */
static int insert(plane_path *found, int count, const plane_path *way)
{
    int at = count < MAX_STARTS ? count : MAX_STARTS;
    for (; at > 0 && value_of(found[at - 1].length) > value_of(way->length); at--)
        if (at < MAX_STARTS) found[at] = found[at - 1];
    if (at < MAX_STARTS) found[at] = *way;
    return count < MAX_STARTS ? count + 1 : count;
}

int fan_starts(const real half_axes[3], const tangent_cone cones[2], int planes,
               path_over starts[MAX_STARTS])
{
    plane_path ways[MANY_PLANES], shortest[MAX_STARTS];
    int count = 0, sections = 0;
    for (int k = 0; k < planes; k++) {
        real c, s;
        plane_angle(k, planes, &c, &s);
        sections += section(half_axes, cones, c, s, ways + sections);
    }
    for (int k = 0; k < planes && sections == planes; k++) {
        const real before = ways[(k + planes - 1) % planes].length, after = ways[(k + 1) % planes].length;
        const real length = ways[k].length;
        if (!(value_of(length) < value_of(before) && value_of(length) <= value_of(after))) continue;
        plane_path way = ways[k];
        refine(half_axes, cones, 2 * PI / planes, before, after, &way);
        count = insert(shortest, count, &way);
    }
    if (!count && sections) shortest[0] = ways[0], count = 1;
    for (int k = 0; k < count; k++) {
        if (value_of(shortest[k].length) > value_of(LONGER * shortest[0].length)) return k;
        starts[k] = shortest[k].way;
    }
    return count;
}
