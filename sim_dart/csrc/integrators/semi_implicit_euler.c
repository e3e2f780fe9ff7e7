/* Steps of the plant: muscles, forward dynamics, semi-implicit Euler, joint limits. */
#include "../cable_friction/cable_friction.h"
#include "../dynamics/external_wrenches.h"
#include "../dynamics/forward.h"
#include "../dynamics/friction.h"
#include "../dynamics/limit_forces.h"
#include "../dynamics/limits.h"
#include "../kinematics/joint_variables.h"
#include "../laws/laws.h"
#include "../loops/loops.h"
#include "../math/elementary.h"
#include "semi_implicit_euler.h"

#include <string.h>

/* Compute qdd. Damping and springs act at the end of the step, to first order: h D + h^2 K is added to M. */
static void accelerate(core *c, real h)
{
    const blob_view *b = &c->blob;
    const real *rates = c->is_driven ? variables_rates(c, c->qd) : c->qd;
    real *load = c->is_driven ? c->row : c->load;
    for (int32_t j = 0; j < b->counts.variables; j++) {
        const real applied = j < b->counts.dofs ? c->torques[j] + c->outer[j] : number(0);
        c->armature[j] = b->armature[j] + h * (b->damping[j] + h * b->stiffness[j]);
        load[j] = applied - b->damping[j] * rates[j] -
                  b->stiffness[j] * (c->at[j] + h * rates[j] - b->rest[j]);
    }
    for (int32_t l = 0; l < b->counts.limit_forces; l++) {
        if (is_soft_limit(c, l)) continue;
        const limit_force f = limit_force_at(c, l);
        const int32_t j = b->limit_variable[l];
        c->armature[j] += h * (f.damping + h * f.stiffness);
        load[j] -= f.damping * rates[j] + f.stiffness * (f.beyond + h * rates[j]);
    }
    if (c->is_driven) variables_fold(c, load, c->load);
    dynamics_accelerate(c, c->qd, c->load, c->armature);
}

/* Compute qd += h qdd, with loops closed. Return whether q then passes a limit within h. */
static truth update_velocities(core *c, real h)
{
    truth passes = {0};
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) {
        c->before[j] = c->qd[j];
        c->qd[j] += h * c->qdd[j];
    }
    if (c->blob.counts.closures) loops_enforce(c, h);
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) {
        const real next = c->q[j] + h * c->qd[j];
        const truth is_below = value_of(next) < value_of(c->blob.lower[j]);
        const truth is_above = value_of(next) > value_of(c->blob.upper[j]);
        passes |= is_below | is_above;
    }
    return passes;
}

/* Maximum velocity, in rad/s or m/s, at which a coordinate that starts beyond a limit returns; as in DART. */
static const constant MAX_RETURN = 10;

/* Apply joint limits and joint friction: no coordinate may pass a limit within h. `passes`: whether one does. */
static void enforce_limits(core *c, real h, truth passes)
{
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) {
        c->low[j] = smaller((c->blob.lower[j] - c->q[j]) / h, number(MAX_RETURN));
        c->high[j] = larger((c->blob.upper[j] - c->q[j]) / h, number(-MAX_RETURN));
    }
    if (c->has_friction) friction_enforce(c, h);
    else if (c->has_soft_limits) limits_enforce_softly(c, h);
    else if (any_of(passes)) limits_enforce(c, c->qd);
}

/* Compute qd at the end of the step, from the forces at its start and the cable friction at its end. */
static void find_velocities(core *c, real h)
{
    if (c->blob.counts.bends) cable_friction_begin(c, h);
    for (;;) {
        accelerate(c, h);
        const truth passes = update_velocities(c, h);
        if (any_of(passes) || c->has_friction || c->has_soft_limits) enforce_limits(c, h, passes);
        if (!c->blob.counts.bends || cable_friction_has_converged(c, h)) return;
    }
}

/* Add the work of the forces at the start of the step at the mean of its velocities: the change of the
   kinetic energy, exactly if M is constant. */
static void add_step_work(core *c, real h)
{
    real muscles = number(0), outer = number(0), damping = number(0);
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) {
        const real way = 0.5 * h * (c->before[j] + c->qd[j]);
        muscles += c->torques[j] * way;
        outer += c->outer[j] * way;
        damping -= c->blob.damping[j] * c->qd[j] * way;
    }
    const real *before = c->before, *after = c->qd;
    if (c->is_driven) {
        before = c->moved, after = c->row;
        variables_follow(c, c->qd, c->row);
        for (int32_t j = c->blob.counts.dofs; j < c->blob.counts.variables; j++)
            damping -= 0.5 * h * (before[j] + after[j]) * c->blob.damping[j] * after[j];
    }
    for (int32_t l = 0; l < c->blob.counts.limit_forces; l++) {
        const int32_t j = c->blob.limit_variable[l];
        if (is_soft_limit(c, l)) continue;
        damping -= 0.5 * h * (before[j] + after[j]) * limit_force_at(c, l).damping * after[j];
    }
    c->work[0] += muscles, c->work[1] += outer, c->work[2] += damping;
}

/* Advance the states of muscles with the path velocities at the end of the step. */
static int advance_muscles(core *c, const real *u, real h)
{
    core_rates(c, c->qd);
    core_advance(c, u, h);
    return muscles_are_sound(c);
}

int euler_steps(core *c, const real *u, const real *extra, real h, int32_t steps)
{
    const int32_t dofs = c->blob.counts.dofs;
    for (; steps > 0; steps--) {
        int bad = muscles_pull(c, u);
        if (bad) return -bad;
        external_wrenches_add(c, extra);
        find_velocities(c, h);
        add_step_work(c, h);
        if (c->has_laws && !advance_muscles(c, u, h)) return dofs + 1;
        for (int32_t j = 0; j < dofs; j++) c->q[j] += h * c->qd[j];
        bad = core_move_checked(c, c->q, c->qd);
        if (bad) return bad;
    }
    return 0;
}

#if !defined(CARDSFLOW_LANES)
int core_step(core *c, const real *u, const real *extra, real h, int32_t steps)
{
    memset(c->work, 0, 4 * sizeof(real));
    return euler_steps(c, u, extra, h, steps);
}
#endif
