/* Coulomb friction of joints, together with their limits. With v0 the velocities that a step would end
   with, and h f_j the largest impulse of friction, the velocities behind the step minimise

     1/2 (v - v0)' M (v - v0) + sum h f_j |v_j|        within  low  and  high

   (Gauss's principle of least constraint). The sum has corners where a coordinate is at a limit and, if it
   slips, where it rests. A coordinate is held at a corner, by an impulse that is found; or it slides
   between two of them, against an impulse of h f_j.

   A round goes straight towards where the sum is least for those that slide, as far as the first corner
   that one of them comes to, and holds it there. Where none comes to one, it lets go that coordinate whose
   corner would have to give most beyond what it can. Every round begins within the limits, and lowers the
   sum, which is strictly convex: no choice of held ones comes again, but by rounding. Few rounds do; their
   number is bounded all the same.                                                                        */
#include "friction.h"

#include "../loops/loops.h"
#include "../math/elementary.h"
#include "forward.h"
#include "limits.h"

#include <string.h>

/* The corners that coordinate j slides between. */
static real lower_corner(const core *c, int32_t j)
{
    return value_of(c->grip[j]) > 0 && value_of(c->slides[j]) > 0 ? larger(c->low[j], 0) : c->low[j];
}

static real upper_corner(const core *c, int32_t j)
{
    return value_of(c->grip[j]) > 0 && value_of(c->slides[j]) < 0 ? smaller(c->high[j], 0) : c->high[j];
}

static void hold(core *c, int32_t j, real corner, int32_t *count)
{
    c->slides[j] = 0;
    c->target[j] = c->sliding[j] = corner;
    c->met[(*count)++] = j;
    limits_respond(c, j);
}

/* free = the velocities before, and what the friction of those that slide does to them. */
static void rub(core *c)
{
    const int32_t dofs = c->blob.counts.dofs;
    for (int32_t j = 0; j < dofs; j++) c->impulse[j] = -c->grip[j] * c->slides[j];
    loops_respond(c, c->impulse, c->free);
    for (int32_t j = 0; j < dofs; j++) c->free[j] += c->unbraked[j];
}

/* All slide as without friction, but for those that so come to a corner. How many these are. */
static int32_t guess(core *c)
{
    const int32_t dofs = c->blob.counts.dofs;
    int32_t count = 0;
    for (int32_t j = 0; j < dofs; j++)
        c->slides[j] = value_of(smaller(larger(c->unbraked[j], c->low[j]), c->high[j])) < 0 ? -1 : 1;
    rub(c);
    memcpy(c->sliding, c->free, (size_t)dofs * sizeof(real));
    for (int32_t j = 0; j < dofs; j++) {
        const real low = lower_corner(c, j), high = upper_corner(c, j);
        if (value_of(c->sliding[j]) <= value_of(low)) hold(c, j, low, &count);
        else if (value_of(c->sliding[j]) >= value_of(high)) hold(c, j, high, &count);
    }
    return count;
}

/* Those that slide go towards qd, as far as the first corner: which one is there, or -1. */
static int32_t slide(core *c, real *corner)
{
    const int32_t dofs = c->blob.counts.dofs;
    int32_t first = -1;
    real share = 1;
    for (int32_t j = 0; j < dofs; j++) {
        const real begin = c->sliding[j], low = lower_corner(c, j), high = upper_corner(c, j), to = c->qd[j];
        const int falls_short = value_of(to) < value_of(low), goes_beyond = value_of(to) > value_of(high);
        if (c->slides[j] == 0 || !(falls_short || goes_beyond)) continue;
        const real end = falls_short ? low : high, part = (end - begin) / (to - begin);
        if (first < 0 || value_of(part) < value_of(share)) share = part, first = j, *corner = end;
    }
    for (int32_t j = 0; j < dofs; j++) {
        if (c->slides[j] == 0) continue;
        const real next = first < 0 ? c->qd[j] : c->sliding[j] + share * (c->qd[j] - c->sliding[j]);
        c->sliding[j] = smaller(larger(next, lower_corner(c, j)), upper_corner(c, j));
    }
    return first;
}

/* By how much the impulse p of coordinate j is more than its corner gives (positive), or less. A limit
   gives any that pushes back into the range; next to a corner friction gives what it does while sliding. */
static real impulse_excess(const core *c, int32_t j, real p)
{
    const real at = c->target[j], grip = c->grip[j];
    const int is_low = value_of(at) <= value_of(c->low[j]), is_high = value_of(at) >= value_of(c->high[j]);
    const real most = value_of(at) > 0 ? -grip : grip, least = value_of(at) < 0 ? grip : -grip;
    if (!is_low && value_of(p) > value_of(most)) return p - most;
    return !is_high && value_of(p) < value_of(least) ? p - least : 0;
}

/* Let the held one slide whose impulse is furthest from what its corner gives: which one, or -1. */
static int32_t let_go(core *c, int32_t *count)
{
    int32_t worst = -1;
    real most = 0;
    for (int32_t a = 0; a < *count; a++) {
        const real by = fabs(impulse_excess(c, (int32_t)c->met[a], c->impulse[a]));
        if (value_of(by) > value_of(most)) most = by, worst = a;
    }
    if (worst < 0) return -1;
    const int32_t j = (int32_t)c->met[worst];
    const int falls = value_of(impulse_excess(c, j, c->impulse[worst])) > 0; /* its velocity, and not below 0 at once */
    c->slides[j] = falls ? (value_of(c->target[j]) > 0 ? 1 : -1) : (value_of(c->target[j]) < 0 ? -1 : 1);
    --*count;
    for (int32_t a = worst; a < *count; a++) c->met[a] = c->met[a + 1];
    return j;
}

void friction_keep(core *c, real h)
{
    const int32_t dofs = c->blob.counts.dofs;
    for (int32_t j = 0; j < dofs; j++) c->grip[j] = h * c->blob.friction[j];
    memcpy(c->unbraked, c->qd, (size_t)dofs * sizeof(real));
    if (!c->blob.counts.closures) dynamics_factor(c, c->blob.armature); /* else that of the loops holds */
    int32_t count = guess(c), freed = -1;
    for (int32_t round = 0; count > 0 || freed >= 0; round++) {
        real corner = 0;
        rub(c);
        limits_solve(c, count);
        limits_apply(c, count);
        const int32_t stuck = slide(c, &corner);
        const int was_right = stuck >= 0 && stuck == freed && value_of(corner) == value_of(c->target[stuck]);
        if (stuck >= 0) hold(c, stuck, corner, &count), freed = -1;
        else freed = let_go(c, &count);
        if ((stuck < 0 && freed < 0) || was_right || round > 8 * dofs) break;
    }
    memcpy(c->qd, c->sliding, (size_t)dofs * sizeof(real));
}
