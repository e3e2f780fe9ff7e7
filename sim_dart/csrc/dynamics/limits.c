/* Joint limits as inelastic stops. Let v be the velocities at the end of the step without limits. The
   impulses p (or, if v are accelerations of coordinates at rest at their limits, the forces p) solve

     v + M^-1 p  within  low  and  high,   p_i pushing inwards, and only at a limit.

   The set of active limits is found by exchange: add the limit that is exceeded most, remove those whose
   impulse would pull. M is positive definite, so that most steps need one or two exchanges; their number is
   bounded.

   A soft limit with a stiffness k, damping d and inertia m, e beyond it, pushes with -k e - d v - m v', but never
   pulls. It is computed as a limit with the bound v - h (d v + k e) / m that yields by 1 / m: MuJoCo's constraints
   of joint limits (Computation, Constraint model) with the regularisation R = 1 / m. */
#include "limits.h"

#include "../kinematics/bodies.h"
#include "../loops/loops.h"
#include "../numbers/real_functions.h"
#include "forward.h"
#include "limit_forces.h"

#include <math.h>
#include <string.h>

static real *entry(const core *c, real *matrix, int32_t row, int32_t column)
{
    return matrix + (size_t)row * (size_t)c->blob.counts.dofs + (size_t)column;
}

/* Return by how much a rate is below its lower bound (negative) or above its upper bound (positive). */
static real excess(const core *c, const real *rates, int32_t j)
{
    const real v = rates[j], low = c->low[j], high = c->high[j];
    return value_of(v) < value_of(low) ? v - low : value_of(v) > value_of(high) ? v - high : 0;
}

/* Return the coordinate that most exceeds a limit that is not active yet, or -1. */
static int32_t furthest(const core *c, const real *rates)
{
    int32_t worst = -1;
    real maximum = 0;
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) {
        const real by = c->side[j] == 0 ? fabs(excess(c, rates, j)) : 0;
        if (value_of(by) > value_of(maximum)) maximum = by, worst = j;
    }
    return worst;
}

/* Compliance of a coordinate at a limit, relative to the tree, if the robot has loops. With loops several
   limits may block the same motion; this compliance distributes the impulse among them. */
static const real YIELDING = PRECISE(1e-9, 1e-5);

/* Compute the impulses that bring each coordinate at a limit to its bound, by Cholesky factorisation. */
void limits_solve(core *c, int32_t count)
{
    real *p = c->impulse;
    for (int32_t a = 0; a < count; a++) {
        const int32_t i = (int32_t)c->met[a];
        for (int32_t b = 0; b <= a; b++) {
            real sum = *entry(c, c->response, i, (int32_t)c->met[b]);
            if (a == b && c->blob.counts.closures) sum += c->yielding[i];
            if (a == b && c->has_soft_limits) sum += c->softness[i];
            for (int32_t k = 0; k < b; k++) sum -= *entry(c, c->factor, a, k) * *entry(c, c->factor, b, k);
            *entry(c, c->factor, a, b) = a == b ? sqrt(sum) : sum / *entry(c, c->factor, b, b);
        }
        real sum = c->target[i] - c->free[i];
        for (int32_t k = 0; k < a; k++) sum -= *entry(c, c->factor, a, k) * p[k];
        p[a] = sum / *entry(c, c->factor, a, a);
    }
    for (int32_t a = count; a-- > 0;) {
        for (int32_t k = a + 1; k < count; k++) p[a] -= *entry(c, c->factor, k, a) * p[k];
        p[a] /= *entry(c, c->factor, a, a);
    }
}

/* Remove the coordinate whose impulse pulls most. Return the number of remaining coordinates. */
static int32_t drop_pulling(core *c, int32_t count)
{
    int32_t worst = -1;
    real maximum = 0;
    for (int32_t a = 0; a < count; a++) {
        const real pull = c->impulse[a] * c->side[(int32_t)c->met[a]];
        if (value_of(pull) > value_of(maximum)) maximum = pull, worst = a;
    }
    if (worst < 0) return count;
    c->side[(int32_t)c->met[worst]] = 0;
    for (int32_t a = worst; a + 1 < count; a++) c->met[a] = c->met[a + 1];
    return count - 1;
}

void limits_respond(core *c, int32_t j)
{
    real *unit = c->impulse;
    memset(unit, 0, (size_t)c->blob.counts.dofs * sizeof(real));
    unit[j] = 1;
    real *change = entry(c, c->response, j, 0);
    dynamics_respond(c, unit, change);
    if (!c->blob.counts.closures) return;
    c->yielding[j] = YIELDING * change[j];
    loops_project(c, NULL, change);
}

static void meet(core *c, const real *rates, int32_t j, int32_t count)
{
    const int under = value_of(excess(c, rates, j)) < 0;
    c->side[j] = under ? -1 : 1;
    c->target[j] = under ? c->low[j] : c->high[j];
    c->met[count] = j;
    limits_respond(c, j);
}

/* Compute rates = free + M^-1 p; set them exactly to the bound at active limits. */
void limits_apply(core *c, int32_t count, real *rates)
{
    const int32_t dofs = c->blob.counts.dofs;
    memcpy(rates, c->free, (size_t)dofs * sizeof(real));
    for (int32_t a = 0; a < count; a++) {
        const real *row = entry(c, c->response, (int32_t)c->met[a], 0);
        for (int32_t j = 0; j < dofs; j++) rates[j] += c->impulse[a] * row[j];
    }
    if (c->blob.counts.closures) return; /* with loops the coordinates depend on each other */
    for (int32_t a = 0; a < count; a++) {
        const int32_t j = (int32_t)c->met[a];
        if (!c->has_soft_limits || c->softness[j] == 0) rates[j] = c->target[j];
    }
}

static void enforce(core *c, real *rates, int is_factored)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    memset(c->side, 0, dofs * sizeof(real));
    int32_t count = 0, next = furthest(c, rates);
    if (next < 0) return;
    memcpy(c->free, rates, dofs * sizeof(real));
    if (!is_factored) dynamics_factor(c, c->blob.armature);
    for (int32_t round = 0; next >= 0 && round < 4 * c->blob.counts.dofs; round++) {
        meet(c, rates, next, count++);
        for (int32_t left = -1; left != count;) {
            if (left >= 0) count = left;
            limits_solve(c, count);
            left = drop_pulling(c, count);
        }
        limits_apply(c, count, rates);
        next = furthest(c, rates);
    }
}

void limits_enforce(core *c, real *rates)
{
    enforce(c, rates, c->blob.counts.closures > 0); /* loops: already done */
}

void limits_enforce_softly(core *c, real h)
{
    for (int32_t l = 0; l < c->blob.counts.limit_forces; l++) {
        if (!is_soft_limit(c, l)) continue;
        const limit_force f = limit_force_at(c, l);
        const int32_t j = c->blob.limit_variable[l];
        const real yield = 1 / c->blob.limit_numbers[LIMIT_NUMBERS * l + 6], v = c->before[j];
        const real bound = v - h * yield * (f.damping * v + f.stiffness * f.beyond);
        const int is_low = value_of(f.beyond) < 0 && value_of(bound) > value_of(c->low[j]);
        const int is_high = value_of(f.beyond) > 0 && value_of(bound) < value_of(c->high[j]);
        if (is_low) c->low[j] = bound;
        if (is_high) c->high[j] = bound;
        c->softness[j] = is_low || is_high ? yield : 0;
    }
    enforce(c, c->qd, 1); /* by the accelerations, with h times the damping as armature */
    memset(c->softness, 0, (size_t)c->blob.counts.dofs * sizeof(real));
}

void limits_stop(core *c)
{
    int any = 0;
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) {
        const int under = value_of(c->q[j]) < value_of(c->blob.lower[j]) || value_of(c->held[j]) < 0;
        const int over = value_of(c->q[j]) > value_of(c->blob.upper[j]) || value_of(c->held[j]) > 0;
        c->low[j] = under ? 0 : -INFINITY;
        c->high[j] = over ? 0 : INFINITY;
        if (under || over) c->q[j] = under ? c->blob.lower[j] : c->blob.upper[j];
        any |= under || over;
    }
    if (!any) return;
    core_move(c, c->q);
    if (c->blob.counts.closures) {
        loops_close(c);
    } else {
        bodies_links(c);
        bodies_inertias(c);
    }
    limits_enforce(c, c->qd);
}
