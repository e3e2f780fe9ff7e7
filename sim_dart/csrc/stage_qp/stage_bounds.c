#include "stage_bounds.h"

#include <string.h>

static const real START_DISTANCE = 1e-2; /* from bounds, relative to their range */

/* A side of a bound: y = sign v. */
typedef struct {
    real sign, bound, *t, *z, *e, *l, *second_z, *second_l, penalty;
    int is_soft;
    size_t i;
} side;

#define FOR_SIDES(s, b)                             \
    for (size_t j_ = 0; j_ < 2 * (s)->total; j_++) \
        if (side_at(s, j_, &(b)))

/* Return whether side j, of 2 total, has a bound. */
static int side_at(const stage_qp *s, size_t j, side *b)
{
    const size_t total = s->total, i = b->i = j < total ? j : j - total;
    b->sign = j < total ? 1 : -1;
    b->bound = j < total ? s->low[i] : -s->high[i];
    if (!isfinite(b->bound) || (i >= s->u && i < s->w)) return 0;
    b->t = s->slack + j, b->z = s->z + j, b->e = s->excess + j, b->l = s->l + j;
    b->second_z = s->second_z + j, b->second_l = s->second_l + j;
    b->penalty = s->penalty[i];
    b->is_soft = b->penalty > 0;
    return 1;
}

/* Steps of t, z, e and l for a step of y, from the linearized conditions t z = m - second_z,
   e l = m - second_l and penalty = z + l. */
typedef struct {
    real weight, force, t, z, e, l; /* next z = force - weight dy */
} side_step;

static side_step step_of(const stage_qp *s, const side *b, real m, real dy)
{
    side_step d = {0, 0, 0, 0, 0, 0};
    const real a = *b->z / *b->t, off = b->sign * s->v[b->i] + *b->e - b->bound - *b->t;
    const real push = (m - *b->second_z) / *b->t - a * off;
    d.weight = a, d.force = push;
    if (b->is_soft) {
        const real ease = *b->l / *b->e, stiff = a + ease;
        const real relief = (m - *b->second_l) / *b->e;
        const real pull = relief - b->penalty;
        d.weight = a * ease / stiff, d.force = (push * ease - a * pull) / stiff;
        d.e = (push + pull - a * dy) / stiff;
        d.l = relief - ease * d.e - *b->l;
    }
    d.t = dy + d.e + off;
    d.z = push - a * (dy + d.e) - *b->z;
    return d;
}

/* Return the step of a side for the computed step of v. */
static side_step current_step(const stage_qp *s, const side *b, real m)
{
    return step_of(s, b, m, b->sign * s->step[b->i]);
}

/* Shorten a step so that a positive number remains positive. */
static void limit(real *length, real value, real change)
{
    if (change < 0) *length = smaller(*length, -value / change);
}

void stage_bounds_weigh(stage_qp *s)
{
    side b;
    memset(s->diagonal, 0, s->total * sizeof(real));
    FOR_SIDES(s, b) s->diagonal[b.i] += step_of(s, &b, 0, 0).weight;
}

void stage_bounds_push(stage_qp *s, real m)
{
    side b;
    memset(s->force, 0, s->total * sizeof(real));
    FOR_SIDES(s, b) s->force[b.i] += b.sign * step_of(s, &b, m, 0).force;
}

real stage_bounds_reach(stage_qp *s, real m)
{
    side b;
    real length = 2;
    FOR_SIDES(s, b)
    {
        const side_step d = current_step(s, &b, m);
        limit(&length, *b.t, d.t), limit(&length, *b.z, d.z);
        if (b.is_soft) limit(&length, *b.e, d.e), limit(&length, *b.l, d.l);
    }
    return length;
}

real stage_bounds_complementarity(stage_qp *s, real m, real length, int keep)
{
    side b;
    real sum = 0, count = 0;
    FOR_SIDES(s, b)
    {
        const side_step d = length > 0 ? current_step(s, &b, m) : (side_step){0, 0, 0, 0, 0, 0};
        sum += (*b.t + length * d.t) * (*b.z + length * d.z), count += 1;
        if (b.is_soft) sum += (*b.e + length * d.e) * (*b.l + length * d.l), count += 1;
        if (keep) *b.second_z = d.t * d.z, *b.second_l = d.e * d.l;
    }
    return count > 0 ? sum / count : 0;
}

void stage_bounds_apply(stage_qp *s, real m, real length)
{
    side b;
    FOR_SIDES(s, b)
    {
        const side_step d = current_step(s, &b, m);
        *b.t += length * d.t, *b.z += length * d.z;
        if (b.is_soft) *b.e += length * d.e, *b.l += length * d.l;
        *b.second_z = *b.second_l = 0;
    }
}

/* Set t within the bounds. Return the mean complementarity of the gradient. */
static real start_slacks(stage_qp *s)
{
    side b;
    real sum = 0, count = 0;
    FOR_SIDES(s, b)
    {
        const real y = b.sign * s->v[b.i], range = s->high[b.i] - s->low[b.i];
        *b.t = larger(y - b.bound, START_DISTANCE * (isfinite(range) ? range : 1));
        sum += fabs(s->slope[b.i]) * *b.t, count += 1;
    }
    return count > 0 ? larger(sum / count, s->tolerance[0]) : 0;
}

void stage_bounds_start(stage_qp *s)
{
    side b;
    const real m = start_slacks(s);
    FOR_SIDES(s, b)
    {
        const real beyond = b.bound - b.sign * s->v[b.i] + *b.t;
        *b.z = m / *b.t;
        *b.second_z = *b.second_l = 0;
        if (!b.is_soft) continue;
        *b.e = larger(beyond, m / b.penalty), *b.l = m / *b.e; /* z + l is near the penalty */
        if (beyond > 0) *b.z = larger(*b.z, b.penalty);
    }
}
