/* The robot in continuous time, for solvers of other tools: derivatives between events, and joint limits as
   events. At an event, a coordinate that reaches its limit stops by an inelastic impulse. It is held there as
   long as the limit pushes; then it is released. */
#include "../core.h"

#include "../dynamics/limits.h"
#include "../loops/loops.h"
#include "../numbers/real_functions.h"
#include "state_rates.h"

#include <math.h>
#include <string.h>

/* Acceleration into the range, in rad/s^2 or m/s^2, at which a held coordinate is released. Above rounding
   errors, so that a coordinate at rest without forces is held, and does not drift through its limit. */
static const real RELEASE = PRECISE(1e-10, 1e-5);

/* Distance from a limit, and velocity, of coordinates at rest there. With loops the coordinates depend on
   each other, so that a held coordinate is at its limit only approximately. */
static const real LOOP_TOLERANCE = PRECISE(1e-7, 1e-4);

static real limit_tolerance(const core *c)
{
    return c->blob.counts.closures ? LOOP_TOLERANCE : 0;
}

static int is_locked(const core *c, int32_t j)
{
    return value_of(c->blob.lower[j]) == value_of(c->blob.upper[j]);
}

/* Compute the forces of the limits on held coordinates, and their effect on qdd. `hold_force` is the force
   that would release the coordinates, positive while the limit pushes. */
static void hold_at_limits(core *c)
{
    const int32_t dofs = c->blob.counts.dofs;
    int32_t count = 0;
    memset(c->hold_force, 0, (size_t)dofs * sizeof(real));
    for (int32_t j = 0; j < dofs; j++) {
        if (c->held[j] == 0) continue;
        c->target[j] = -c->held[j] * RELEASE;
        c->met[count++] = j;
        limits_respond(c, j);
    }
    if (!count) return;
    memcpy(c->free, c->qdd, (size_t)dofs * sizeof(real));
    limits_solve(c, count);
    for (int32_t a = 0; a < count; a++) {
        const int32_t j = (int32_t)c->met[a];
        c->hold_force[j] = is_locked(c, j) ? 1 : -c->held[j] * c->impulse[a];
        c->target[j] = 0;
    }
    limits_solve(c, count);
    limits_apply(c, count, c->qdd);
}

int core_derivative(core *c, const real *u, const real *extra)
{
    const int bad = state_rates_evaluate(c, u, extra);
    if (bad) return bad;
    memset(c->work, 0, 4 * sizeof(real));
    state_rates_add_work(c, 1);
    hold_at_limits(c);
    return 0;
}

/* Set `held` for all coordinates at or beyond a limit. */
static void find_met(core *c)
{
    const real near = limit_tolerance(c);
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) {
        const int under = value_of(c->q[j]) <= value_of(c->blob.lower[j] + near);
        const int over = value_of(c->q[j]) >= value_of(c->blob.upper[j] - near);
        c->held[j] = under ? -1 : over ? 1 : 0;
    }
}

/* Hold those coordinates at a limit that rest there and would pass it; release the others. */
static void choose_held(core *c)
{
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) {
        const int rests = value_of(fabs(c->qd[j])) <= value_of(limit_tolerance(c));
        c->low[j] = rests && value_of(c->held[j]) < 0 ? RELEASE : -INFINITY;
        c->high[j] = rests && value_of(c->held[j]) > 0 ? -RELEASE : INFINITY;
        if (is_locked(c, j)) c->low[j] = c->high[j] = 0;
    }
    limits_enforce(c, c->qdd);
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) c->held[j] = is_locked(c, j) ? -1 : c->side[j];
}

int core_meet_limits(core *c, const real *u, const real *extra)
{
    if (c->blob.counts.closures) loops_close(c);
    find_met(c);
    limits_stop(c);
    const int bad = state_rates_evaluate(c, u, extra);
    if (bad) return bad;
    choose_held(c);
    return 0;
}
