/* A cable off a swivelling pulley.

   The cable arrives at the fixed point F along v. The plane of the pulley swivels about v to contain the far
   end b. In that plane, with x along v and y towards b, the pulley is a circle about (0, R), and the cable
   leaves it along a tangent to b: l = R turn + tangent. Swivelling moves the pulley only perpendicular to
   its plane, where the cable does not pull; so dl/db is the direction of the tangent.

   CASPR computes the arc from a cosine, which is equal up to half a turn, and the complement of a turn
   beyond. If the far end is inside the circle, a smaller circle is used that touches v at F and passes
   through the far end. */
#include "pulley.h"

#include "../math/elementary.h"
#include "../math/vectors.h"

#include <math.h>
#include <string.h>

#define SMALL_CHORD PRECISE(1e-4, 3e-2) /* in [rad]: below, a series is more accurate */

static void leave_along(contact *out, const real v[3], const real e[3], real turn)
{
    const real c = cosine(turn), s = sine(turn);
    for (int k = 0; k < 3; k++) out->pull.leaving[k] = c * v[k] + s * e[k];
}

/* Compute l = d b / sin b, with the chord d from F at the angle b to v, which is half the angle of the arc. */
static void end_inside(const real v[3], const real e[3], real x, real y, contact *out)
{
    const real d = sqrt(x * x + y * y), chord = arc_tangent(y, x), bb = chord * chord;
    const int is_small = value_of(chord) < SMALL_CHORD;
    const real half_height = sine(chord), ratio = is_small ? 1 + bb / 6 : chord / half_height;
    const real change = is_small ? chord / 3 : (half_height - chord * cosine(chord)) / (half_height * half_height);
    const real radial[2] = {cosine(chord), half_height};
    out->pull.length = ratio * d;
    out->pull.angle = 2 * chord;
    for (int k = 0; k < 3; k++)
        out->pull.leaving[k] = (ratio * radial[0] - change * radial[1]) * v[k] +
                          (ratio * radial[1] + change * radial[0]) * e[k];
}

/* Return the turn of exp(i turn) = i (x + i (y - R)) (R - i tangent) / |b - centre|^2. */
static real turn_angle(real x, real y, real R, real tangent)
{
    const real turn = arc_tangent(x * R + (y - R) * tangent, x * tangent - (y - R) * R);
    if (value_of(turn) >= 0) return turn;
    /* either rounding of a straight cable, or more than half a turn */
    return value_of(x) > 0 ? 0 : turn + 2 * PI;
}

void pulley_off(const real F[3], const real v[3], real R, const real b[3], contact *out)
{
    real w[3], e[3];
    for (int k = 0; k < 3; k++) w[k] = b[k] - F[k];
    const real x = dot3(w, v);
    for (int k = 0; k < 3; k++) e[k] = w[k] - x * v[k];
    const real y = sqrt(dot3(e, e)), squared = x * x + y * y - 2 * y * R;
    for (int k = 0; k < 3; k++) e[k] = value_of(y) > 0 ? e[k] / y : 0;
    if (y == 0) { /* straight on or back: any plane is valid */
        const real other[3] = {value_of(fabs(v[0])) < 0.5, value_of(fabs(v[0])) >= 0.5, 0};
        cross3(e, v, other);
        const real norm = sqrt(dot3(e, e));
        for (int k = 0; k < 3; k++) e[k] /= norm;
    }
    memcpy(out->pull.entering, v, sizeof out->pull.entering);
    memcpy(out->touch, F, sizeof out->touch);
    cross3(out->axis, v, e);
    if (value_of(squared) < 0) {
        end_inside(v, e, x, y, out);
        memcpy(out->lift, b, sizeof out->lift);
        return;
    }
    const real tangent = sqrt(squared), turn = turn_angle(x, y, R, tangent);
    out->pull.length = R * turn + tangent;
    out->pull.angle = turn;
    leave_along(out, v, e, turn);
    for (int k = 0; k < 3; k++)
        out->lift[k] = F[k] + R * (sine(turn) * v[k] + (1 - cosine(turn)) * e[k]);
}
