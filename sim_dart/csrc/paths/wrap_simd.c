/* Parallel computation of the most frequent wraps of wrap.c and of MuJoCo's rule: ends outside of a sphere or
   a cylinder, no turns, on the shorter way.

   One wrap is a long chain of roots, quotients and an arc tangent, each of which waits for the previous one.
   Here each operation is applied to all wraps before the next operation, in loops without branches, which
   compilers turn into vector instructions. Lengths are computed as in wrap.c. With g = R / |a x b|, the
   directions of the tangents (ta a + R n x a and so on) are

     entering   g b - (g a.b + ta) / a.a a,     leaving   (g a.b + tb) / b.b b - g a,

   from (a x b) x b = (a.b) b - (b.b) a. This loses digits if the straight line nearly passes through the
   axis; wrap.c and wrap_rules.c compute this case and all other rare cases.

   MuJoCo's rule depends on the direction s from the centre to the side point. If the straight line meets the
   circle, the cable is on the shorter way unless s lies opposite to both ends:

     (a x s).(a x b) = a.a s.b - a.b s.a <= 0     and     (s x b).(a x b) = b.b s.a - a.b s.b <= 0. */
#include "wrap_simd.h"

#include "../math/elementary.h"
#include "../math/quick_arc.h"
#include "../math/vectors.h"

#include <math.h>
#include <string.h>
#if HAS_WIDE_LANES
#include <cpuid.h>
#endif

/* Square of the minimum sine of the angle between the ends. */
#define MIN_SINE2 1e-3

/* One lane per wrap; names as in `view` of wrap.c. */
typedef struct {
    real a[3][LANES], b[3][LANES], n[3][LANES], d[3][LANES]; /* ends, seen from the centre; axis; b - a */
    real s[3][LANES]; /* direction to the side point */
    real aa[LANES], bb[LANES], dd[LANES], ab[LANES], xx[LANES], h[LANES];
    real is_touched[LANES]; /* 1 or 0 */
    real ta[LANES], tb[LANES], cross[LANES];
    real re[LANES], im[LANES]; /* complex number whose angle is the angle of contact */
    real angle[LANES], P[LANES], per[LANES]; /* length perpendicular to the axis; inverse of the whole length */
} lane_views;

/* Lanes beyond the last wrap are zero, so that all loops take whole vectors. */
IN_LANES void gather(const core *c, const wrap_lanes *out, lane_views *v)
{
    for (int i = 0; i < out->count; i++) {
        const int32_t w = (int32_t)value_of(c->lane_wrap[out->first + i]);
        const real *A = c->point + 3 * c->blob.wrap_point[w], *B = A + 3;
        const real *centre = c->surface_place + 6 * c->blob.wrap_surface[w], *axis = centre + 3;
        for (int j = 0; j < 3; j++) {
            v->a[j][i] = A[j] - centre[j], v->b[j][i] = B[j] - centre[j];
            v->n[j][i] = axis[j], v->d[j][i] = B[j] - A[j];
        }
    }
    for (int i = out->count; i < out->padded; i++)
        for (int j = 0; j < 3; j++) v->a[j][i] = v->b[j][i] = v->n[j][i] = v->d[j][i] = v->s[j][i] = 0;
}

/* Compute the directions to the side points. */
IN_LANES void gather_sides(const core *c, const wrap_lanes *out, lane_views *v)
{
    for (int i = 0; i < out->count; i++) {
        const int32_t w = (int32_t)value_of(c->lane_wrap[out->first + i]);
        const int32_t frame = c->blob.surface_frame[c->blob.wrap_surface[w]];
        const real *local = c->lane_aside + 3 * (out->first + i), *R = c->rotation + 9 * frame;
        for (int j = 0; j < 3; j++) v->s[j][i] = frame < 0 ? local[j] : dot3(R + 3 * j, local);
    }
}

/* Return 1 or 0: products are "and" in a loop of real numbers. */
static inline real is_less(real a, real b)
{
    return value_of(a) < value_of(b) ? 1 : 0;
}

/* Compute the ends perpendicular to the axis, and whether the cable touches. `has_rules`: MuJoCo's rule
   occurs. */
IN_LANES void compute_views(const core *c, int has_rules, lane_views *restrict v, wrap_lanes *restrict out)
{
    const real *radius = c->lane_radius + out->first, *half = c->lane_half + out->first;
    const real *side = c->lane_sense + out->first, *has_axis = c->lane_has_axis + out->first;
    const real *is_mujoco = c->lane_is_mujoco + out->first, *is_guided = c->lane_is_guided + out->first;
    for (int i = 0; i < out->padded; i++) {
        const real n0 = v->n[0][i], n1 = v->n[1][i], n2 = v->n[2][i];
        const real p0 = v->a[0][i], p1 = v->a[1][i], p2 = v->a[2][i];
        const real q0 = v->b[0][i], q1 = v->b[1][i], q2 = v->b[2][i];
        const real za = has_axis[i] * (p0 * n0 + p1 * n1 + p2 * n2);
        const real zb = has_axis[i] * (q0 * n0 + q1 * n1 + q2 * n2);
        const real a0 = p0 - za * n0, a1 = p1 - za * n1, a2 = p2 - za * n2;
        const real b0 = q0 - zb * n0, b1 = q1 - zb * n1, b2 = q2 - zb * n2;
        const real d0 = b0 - a0, d1 = b1 - a1, d2 = b2 - a2;
        const real aa = a0 * a0 + a1 * a1 + a2 * a2, bb = b0 * b0 + b1 * b1 + b2 * b2;
        const real ad = a0 * d0 + a1 * d1 + a2 * d2, dd = d0 * d0 + d1 * d1 + d2 * d2;
        const real x0 = a1 * b2 - a2 * b1, x1 = a2 * b0 - a0 * b2, x2 = a0 * b1 - a1 * b0;
        const real xx = x0 * x0 + x1 * x1 + x2 * x2, RR = radius[i] * radius[i];
        const real about = side[i] * (x0 * n0 + x1 * n1 + x2 * n2), inner = smaller(aa, bb);
        const real is_after_a = is_less(ad, 0), is_before_b = is_less(-ad, dd), ab = aa + ad;
        const real is_met = is_after_a * is_before_b * is_less(xx, RR * dd);
        const real is_shrunk = is_less(inner, RR), is_off = is_less(half[i], larger(fabs(za), fabs(zb)));
        const real is_aside = is_less(MIN_SINE2 * aa * bb, xx), is_longer = is_less(about, 0);
        real is_plain = (1 - is_shrunk) * (1 - is_off) * is_aside * (1 - is_longer), is_bent = is_met, is_against = 0;
        if (has_rules) {
            const real sa = v->s[0][i] * a0 + v->s[1][i] * a1 + v->s[2][i] * a2;
            const real sb = v->s[0][i] * b0 + v->s[1][i] * b1 + v->s[2][i] * b2;
            const real is_opposite = (1 - is_less(ab * sa, aa * sb)) * (1 - is_less(ab * sb, bb * sa));
            const real is_outside = 1 - is_mujoco[i] * is_shrunk;
            /* the direction of s at the nearest point of the straight line, if it does not meet the circle */
            const real between = dd * sa - ad * (sb - sa), before = is_before_b != 0 ? between : sb;
            const real near = is_after_a != 0 ? before : sa;
            is_plain *= 1 - is_guided[i] * is_opposite;
            is_bent = is_met * is_outside;
            is_against = is_guided[i] * is_outside * (1 - is_met) * is_less(near, 0);
        }
        v->a[0][i] = a0, v->a[1][i] = a1, v->a[2][i] = a2;
        v->b[0][i] = b0, v->b[1][i] = b1, v->b[2][i] = b2;
        v->aa[i] = aa, v->bb[i] = bb, v->dd[i] = dd, v->ab[i] = ab, v->xx[i] = xx, v->h[i] = zb - za;
        v->is_touched[i] = is_bent * is_plain;
        out->is_alone[i] = is_bent * (1 - is_plain) + is_against;
    }
}

IN_LANES int is_any_touched(const lane_views *v, int count)
{
    int is_any = 0;
    for (int i = 0; i < count; i++) is_any |= v->is_touched[i] != 0;
    return is_any;
}

/* See contact_angle in wrap.c. */
IN_LANES void multiply(const real *radius, int count, lane_views *v)
{
    for (int i = 0; i < count; i++) {
        const real R = radius[i], RR = R * R, ab = v->ab[i], cross = sqrt(v->xx[i]);
        const real ta = sqrt(larger(v->aa[i] - RR, 0)), tb = sqrt(larger(v->bb[i] - RR, 0));
        const real re = RR - ta * tb, im = -R * (ta + tb);
        v->ta[i] = ta, v->tb[i] = tb, v->cross[i] = cross;
        v->im[i] = ab * im + cross * re, v->re[i] = ab * re - cross * im;
    }
}

IN_LANES void turn(int count, lane_views *v)
{
    for (int i = 0; i < count; i++) v->angle[i] = upper_arc_tangent(larger(v->im[i], 0), v->re[i]);
}

/* Compute length and slope; a cable that does not touch is straight perpendicular to the axis. */
IN_LANES void climb(const real *radius, lane_views *v, wrap_lanes *restrict out)
{
    for (int i = 0; i < out->padded; i++) {
        const real bent = v->ta[i] + v->tb[i] + radius[i] * v->angle[i], straight = sqrt(v->dd[i]);
        const real h = v->h[i], P = v->is_touched[i] != 0 ? bent : straight;
        const real length = sqrt(P * P + h * h), per = value_of(length) > 0 ? 1 / length : 0;
        v->P[i] = P, v->per[i] = per;
        out->length[i] = length;
    }
}

/* Compute the direction at the end e; f is the other end; `sign` is 1 for the incoming cable. */
IN_LANES void direct_lanes(const real *radius, int count, const lane_views *v, real (*e)[LANES], real (*f)[LANES],
                         const real *ee, const real *tangent, real sign, real (*restrict out)[LANES])
{
    for (int i = 0; i < count; i++) {
        const real g = radius[i] / v->cross[i], at_e = (g * v->ab[i] + tangent[i]) / ee[i];
        const real per = sign * v->per[i], level = per * v->P[i], climb = v->per[i] * v->h[i];
        const real along_e = v->is_touched[i] != 0 ? level * at_e : per;
        const real along_f = v->is_touched[i] != 0 ? level * g : per;
        out[0][i] = along_e * e[0][i] - along_f * f[0][i] + climb * v->n[0][i];
        out[1][i] = along_e * e[1][i] - along_f * f[1][i] + climb * v->n[1][i];
        out[2][i] = along_e * e[2][i] - along_f * f[2][i] + climb * v->n[2][i];
    }
}

/* Compute the same for cables that all do not touch. */
IN_LANES void straight_lanes(const lane_views *v, wrap_lanes *restrict out)
{
    for (int i = 0; i < out->padded; i++) {
        const real d0 = v->d[0][i], d1 = v->d[1][i], d2 = v->d[2][i];
        const real length = sqrt(d0 * d0 + d1 * d1 + d2 * d2), per = value_of(length) > 0 ? 1 / length : 0;
        out->length[i] = length;
        out->entering[0][i] = out->leaving[0][i] = per * d0;
        out->entering[1][i] = out->leaving[1][i] = per * d1;
        out->entering[2][i] = out->leaving[2][i] = per * d2;
    }
}

IN_LANES void fill(const core *c, wrap_lanes *out)
{
    const real *radius = c->lane_radius + out->first;
    const int padded = out->padded;
    lane_views v;
    gather(c, out, &v);
    if (c->has_rules) {
        gather_sides(c, out, &v);
        compute_views(c, 1, &v, out);
    } else {
        compute_views(c, 0, &v, out);
    }
    if (!is_any_touched(&v, out->count)) {
        straight_lanes(&v, out);
        return;
    }
    multiply(radius, padded, &v);
    turn(padded, &v);
    climb(radius, &v, out);
    if (c->wrap_ends & ENTERING) direct_lanes(radius, padded, &v, v.a, v.b, v.aa, v.ta, -1, out->entering);
    if (c->wrap_ends & LEAVING) direct_lanes(radius, padded, &v, v.b, v.a, v.bb, v.tb, 1, out->leaving);
}

#if HAS_WIDE_LANES
/* The same operations on vectors of twice the size: the results are bit-identical. */
__attribute__((target("avx2"))) static void fill_wide(const core *c, wrap_lanes *out)
{
    fill(c, out);
}
#endif

/* Return the `vector_size` of processor and operating system. */
static int32_t vector_size(void)
{
#if HAS_WIDE_LANES
    uint32_t a, b, c, d, saved, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE)) return 0;
    __asm__("xgetbv" : "=a"(saved), "=d"(high) : "c"(0));
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d) || (saved & 6) != 6 || !(b & bit_AVX2)) return 0;
    return (saved & 0xe6) == 0xe6 && (b & bit_AVX512F) && (b & bit_AVX512DQ) ? 8 : 4;
#else
    return 0;
#endif
}

void wrap_simd_fill(const core *c, int32_t first, wrap_lanes *out)
{
    const int32_t left = c->lanes - first;
    const int count = left < LANES ? (int)left : LANES;
    out->first = first, out->count = count;
    out->padded = HAS_TANGENT ? count : (count + LANE_PADDING) / (LANE_PADDING + 1) * (LANE_PADDING + 1);
    out->is_alone[0] = count == 1; /* faster separately */
    if (count == 1) return;
#if HAS_WIDE_LANES
    if (c->vector_size >= 4) {
        fill_wide(c, out);
        return;
    }
#endif
    fill(c, out);
}

/* Return whether a wrap shares its segment. `pulley` is the first one that is not before it. */
static int shares_segment(const blob_view *blob, int32_t w, int32_t *pulley)
{
    const int32_t *point = blob->wrap_point + w, wraps = blob->counts.wraps, pulleys = blob->counts.pulleys;
    while (*pulley < pulleys && blob->pulley_point[*pulley] < *point) ++*pulley;
    return (w > 0 && point[-1] == *point) || (w + 1 < wraps && point[1] == *point) ||
           (*pulley < pulleys && blob->pulley_point[*pulley] == *point);
}

/* Compute the direction to the side point of MuJoCo's rule, and whether it is fixed to the surface. Return
   whether it is inside, so that the cable runs inside. */
static int find_side(const blob_view *blob, int32_t w, real aside[3], int *is_fixed)
{
    const int32_t g = blob->wrap_guide[w], s = blob->wrap_surface[w];
    const real *centre = blob->surface_centre + 3 * s, R = blob->surface_radius[s];
    *is_fixed = 1;
    for (int j = 0; j < 3; j++) aside[j] = 0;
    if (blob->wrap_rule[w] != RULE_MUJOCO || g < 0) return 0;
    *is_fixed = blob->guide_frame[g] == blob->surface_frame[s];
    for (int j = 0; j < 3; j++) aside[j] = blob->guide_vector[3 * g + j] - centre[j];
    return *is_fixed && value_of(dot3(aside, aside)) < value_of(R * R);
}

/* Add a wrap to the lanes. */
static void add_to_lanes(core *c, int32_t w, const real aside[3])
{
    const blob_view *blob = &c->blob;
    const int32_t l = c->lanes++, s = blob->wrap_surface[w];
    const int is_mujoco = blob->wrap_rule[w] == RULE_MUJOCO;
    const int has_ends = value_of(blob->surface_half[s]) > 0 && !is_mujoco;
    c->lane_wrap[l] = w;
    c->lane_radius[l] = blob->surface_radius[s], c->lane_has_axis[l] = blob->surface_kind[s] == SURFACE_CYLINDER;
    c->lane_half[l] = has_ends ? blob->surface_half[s] : INFINITY;
    c->lane_sense[l] = blob->wrap_side[w];
    c->lane_is_mujoco[l] = is_mujoco, c->lane_is_guided[l] = is_mujoco && blob->wrap_guide[w] >= 0;
    memcpy(c->lane_aside + 3 * l, aside, 3 * sizeof(real));
    c->wrap_ends |= wrap_ends(blob, w), c->has_rules |= is_mujoco;
}

void wrap_simd_prepare(core *c)
{
    const blob_view *blob = &c->blob;
    int32_t pulley = 0, muscle = 0, end = blob->counts.muscles ? blob->muscle_points[0] : 0;
    c->wrap_ends = c->has_rules = c->lanes = 0;
    c->vector_size = vector_size();
    for (int32_t w = 0; w < blob->counts.wraps; w++) {
        const int32_t kind = blob->surface_kind[blob->wrap_surface[w]];
        int is_fixed;
        real aside[3];
        while (end <= blob->wrap_point[w]) end += blob->muscle_points[++muscle];
        const int is_inside = find_side(blob, w, aside, &is_fixed) || blob->wrap_side[w] == WRAP_INSIDE;
        const int is_special = is_inside || !is_fixed || kind == SURFACE_ELLIPSOID || blob->wrap_turns[w] ||
                               c->is_routed[muscle] != 0 || shares_segment(blob, w, &pulley);
        c->wrap_is_inside[w] = is_inside, c->wrap_is_special[w] = is_special;
        if (!is_special) add_to_lanes(c, w, aside);
    }
}
