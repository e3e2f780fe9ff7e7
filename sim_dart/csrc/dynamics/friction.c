/* Coulomb friction of joints, together with joint limits. Let v0 be the velocities at the end of the step
   without friction and limits, and h f_j the maximum impulse of friction. The velocities at the end of the
   step minimise

     1/2 (v - v0)' M (v - v0) + sum h f_j |v_j|        within  low  and  high

   (Gauss's principle of least constraint). The objective has kinks at the limits and, for coordinates with
   friction, at zero velocity. A coordinate is either held at a kink by an unknown impulse, or slides between
   two kinks against an impulse of h f_j.

   An iteration moves the sliding coordinates straight towards their minimum, until the first of them reaches
   a kink and is held there. If none reaches a kink, the held coordinate whose impulse exceeds its bound most
   is released. Every iterate is within the limits and lowers the objective, which is strictly convex, so no
   set of held coordinates repeats except through rounding. Usually few iterations suffice; their number is
   bounded. */
#include "friction.h"

#include "../loops/loops.h"
#include "../math/elementary.h"
#include "forward.h"
#include "limits.h"

#include <string.h>

/* Return the lower kink of the interval in which coordinate j slides. */
static real lower_kink(const core *c, int32_t j)
{
    return value_of(c->grip[j]) > 0 && value_of(c->slides[j]) > 0 ? larger(c->low[j], 0) : c->low[j];
}

static real upper_kink(const core *c, int32_t j)
{
    return value_of(c->grip[j]) > 0 && value_of(c->slides[j]) < 0 ? smaller(c->high[j], 0) : c->high[j];
}

static void hold_coordinate(core *c, int32_t j, real corner, int32_t *count)
{
    c->slides[j] = 0;
    c->target[j] = c->sliding[j] = corner;
    c->met[(*count)++] = j;
    limits_respond(c, j);
}

/* Compute free = the velocities without friction plus the effect of the friction of sliding coordinates. */
static void apply_sliding_friction(core *c)
{
    const int32_t dofs = c->blob.counts.dofs;
    for (int32_t j = 0; j < dofs; j++) c->impulse[j] = -c->grip[j] * c->slides[j];
    loops_respond(c, c->impulse, c->free);
    for (int32_t j = 0; j < dofs; j++) c->free[j] += c->unbraked[j];
}

/* Let all coordinates slide in the direction without friction, and hold those that reach a kink. Return the
   number of held coordinates. */
static int32_t guess_sliding(core *c)
{
    const int32_t dofs = c->blob.counts.dofs;
    int32_t count = 0;
    for (int32_t j = 0; j < dofs; j++)
        c->slides[j] = value_of(smaller(larger(c->unbraked[j], c->low[j]), c->high[j])) < 0 ? -1 : 1;
    apply_sliding_friction(c);
    memcpy(c->sliding, c->free, (size_t)dofs * sizeof(real));
    for (int32_t j = 0; j < dofs; j++) {
        const real low = lower_kink(c, j), high = upper_kink(c, j);
        if (value_of(c->sliding[j]) <= value_of(low)) hold_coordinate(c, j, low, &count);
        else if (value_of(c->sliding[j]) >= value_of(high)) hold_coordinate(c, j, high, &count);
    }
    return count;
}

/* Move the sliding coordinates towards qd, up to the first kink. Return the coordinate at that kink, or -1. */
static int32_t move_sliding(core *c, real *corner)
{
    const int32_t dofs = c->blob.counts.dofs;
    int32_t first = -1;
    real share = 1;
    for (int32_t j = 0; j < dofs; j++) {
        const real begin = c->sliding[j], low = lower_kink(c, j), high = upper_kink(c, j), to = c->qd[j];
        const int falls_short = value_of(to) < value_of(low), goes_beyond = value_of(to) > value_of(high);
        if (c->slides[j] == 0 || !(falls_short || goes_beyond)) continue;
        const real end = falls_short ? low : high, part = (end - begin) / (to - begin);
        if (first < 0 || value_of(part) < value_of(share)) share = part, first = j, *corner = end;
    }
    for (int32_t j = 0; j < dofs; j++) {
        if (c->slides[j] == 0) continue;
        const real next = first < 0 ? c->qd[j] : c->sliding[j] + share * (c->qd[j] - c->sliding[j]);
        c->sliding[j] = smaller(larger(next, lower_kink(c, j)), upper_kink(c, j));
    }
    return first;
}

/* Return by how much the impulse p of coordinate j exceeds the bound of its kink (positive) or falls below
   it. A limit provides any impulse back into the range; on the other side of a kink, friction provides its
   sliding impulse. */
static real impulse_excess(const core *c, int32_t j, real p)
{
    const real at = c->target[j], grip = c->grip[j];
    const int is_low = value_of(at) <= value_of(c->low[j]), is_high = value_of(at) >= value_of(c->high[j]);
    const real maximum = value_of(at) > 0 ? -grip : grip, minimum = value_of(at) < 0 ? grip : -grip;
    if (!is_low && value_of(p) > value_of(maximum)) return p - maximum;
    return !is_high && value_of(p) < value_of(minimum) ? p - minimum : 0;
}

/* Release the held coordinate whose impulse exceeds its bound most. Return its index, or -1. */
static int32_t release_coordinate(core *c, int32_t *count)
{
    int32_t worst = -1;
    real maximum = 0;
    for (int32_t a = 0; a < *count; a++) {
        const real by = fabs(impulse_excess(c, (int32_t)c->met[a], c->impulse[a]));
        if (value_of(by) > value_of(maximum)) maximum = by, worst = a;
    }
    if (worst < 0) return -1;
    const int32_t j = (int32_t)c->met[worst];
    const int falls = value_of(impulse_excess(c, j, c->impulse[worst])) > 0; /* sign of its velocity */
    c->slides[j] = falls ? (value_of(c->target[j]) > 0 ? 1 : -1) : (value_of(c->target[j]) < 0 ? -1 : 1);
    --*count;
    for (int32_t a = worst; a < *count; a++) c->met[a] = c->met[a + 1];
    return j;
}

void friction_enforce(core *c, real h)
{
    const int32_t dofs = c->blob.counts.dofs;
    for (int32_t j = 0; j < dofs; j++) c->grip[j] = h * c->blob.friction[j];
    memcpy(c->unbraked, c->qd, (size_t)dofs * sizeof(real));
    if (!c->blob.counts.closures) dynamics_factor(c, c->blob.armature); /* loops: already done */
    int32_t count = guess_sliding(c), freed = -1;
    for (int32_t round = 0; count > 0 || freed >= 0; round++) {
        real corner = 0;
        apply_sliding_friction(c);
        limits_solve(c, count);
        limits_apply(c, count, c->qd);
        const int32_t stuck = move_sliding(c, &corner);
        const int was_right = stuck >= 0 && stuck == freed && value_of(corner) == value_of(c->target[stuck]);
        if (stuck >= 0) hold_coordinate(c, stuck, corner, &count), freed = -1;
        else freed = release_coordinate(c, &count);
        if ((stuck < 0 && freed < 0) || was_right || round > 8 * dofs) break;
    }
    memcpy(c->qd, c->sliding, (size_t)dofs * sizeof(real));
}
