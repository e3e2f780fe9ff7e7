/* Steps of the plant by the fourth-order Runge-Kutta method: all terms are explicit and evaluated at all
   four stages. A joint that passes its limit is set to the limit at the end of the step, and stopped. */
#include "../dynamics/external_wrenches.h"
#include "../dynamics/limit_forces.h"
#include "../dynamics/limits.h"
#include "../kinematics/bodies.h"
#include "../kinematics/joint_variables.h"
#include "../laws/laws.h"
#include "../loops/loops.h"

#include <math.h>
#include <string.h>

/* Compute the rates of q, qd and law_states. Return 0, or 1 + the index of the first invalid command. */
static int evaluate_rates(core *c, const real *u, const real *extra)
{
    const blob_view *b = &c->blob;
    const int bad = muscles_pull(c, u);
    if (bad) return bad;
    external_wrenches_add(c, extra);
    const real *rates = c->is_driven ? variables_rates(c, c->qd) : c->qd;
    real *load = c->is_driven ? c->row : c->load;
    for (int32_t j = 0; j < b->counts.variables; j++) {
        const real given = j < b->counts.dofs ? c->torques[j] + c->outer[j] : 0;
        load[j] = given - b->damping[j] * rates[j] - b->stiffness[j] * (c->at[j] - b->rest[j]);
    }
    for (int32_t l = 0; l < b->counts.limit_forces; l++) {
        const limit_force f = limit_force_at(c, l);
        load[b->limit_variable[l]] -= f.damping * rates[b->limit_variable[l]] + f.stiffness * f.beyond;
    }
    if (c->is_driven) variables_fold(c, load, c->load);
    core_accelerate(c, c->qd, c->load, b->armature);
    return c->has_laws ? core_law_rates(c, u) : 0;
}

static void begin_step(core *c)
{
    const size_t dofs = (size_t)c->blob.counts.dofs, states = (size_t)c->blob.law_states;
    memcpy(c->before, c->q, dofs * sizeof(real));
    memcpy(c->before + dofs, c->qd, dofs * sizeof(real));
    memcpy(c->before + 2 * dofs, c->law_states, states * sizeof(real));
    memset(c->slopes, 0, (2 * dofs + states) * sizeof(real));
}

/* Add the work of torques, external forces and damping in a time h. */
static void add_work(core *c, real h)
{
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) {
        const real way = h * c->qd[j];
        c->work[0] += c->torques[j] * way;
        c->work[1] += c->outer[j] * way;
        c->work[2] -= c->blob.damping[j] * c->qd[j] * way;
    }
    const real *rates = c->is_driven ? c->moved : c->qd;
    for (int32_t j = c->blob.counts.dofs; j < c->blob.counts.variables; j++)
        c->work[2] -= c->blob.damping[j] * rates[j] * rates[j] * h;
    for (int32_t l = 0; l < c->blob.counts.limit_forces; l++) {
        const real rate = rates[c->blob.limit_variable[l]];
        c->work[2] -= limit_force_at(c, l).damping * rate * rate * h;
    }
}

/* Add weight * rates to slopes, and the work of this share of the step. */
static void add_stage(core *c, real weight, real h)
{
    const int32_t dofs = c->blob.counts.dofs, states = c->blob.law_states;
    for (int32_t j = 0; j < dofs; j++) {
        c->slopes[j] += weight * c->qd[j];
        c->slopes[dofs + j] += weight * c->qdd[j];
    }
    for (int32_t k = 0; k < states; k++) c->slopes[2 * dofs + k] += weight * c->law_rates[k];
    add_work(c, weight * h / 6);
}

/* Move to before + h rates. Return the same as core_step. */
static int move_to(core *c, real h, const real *q_rates, const real *qd_rates, const real *x_rates)
{
    const int32_t dofs = c->blob.counts.dofs, states = c->blob.law_states;
    for (int32_t j = 0; j < dofs; j++) c->q[j] = c->before[j] + h * q_rates[j]; /* q_rates may be qd itself */
    for (int32_t j = 0; j < dofs; j++) c->qd[j] = c->before[dofs + j] + h * qd_rates[j];
    for (int32_t k = 0; k < states; k++) c->law_states[k] = c->before[2 * dofs + k] + h * x_rates[k];
    return muscles_are_sound(c) ? core_move_checked(c, c->q, c->qd) : dofs + 1;
}

/* Set coordinates beyond a limit to the limit and stop them. */
static void stop_at_limits(core *c)
{
    int any = 0;
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) {
        const int under = value_of(c->q[j]) < value_of(c->blob.lower[j]);
        const int over = value_of(c->q[j]) > value_of(c->blob.upper[j]);
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
    limits_enforce(c);
}

static int one_step(core *c, const real *u, const real *extra, real h)
{
    static const real weights[4] = {1, 2, 2, 1}, shares[3] = {0.5, 0.5, 1};
    const int32_t dofs = c->blob.counts.dofs;
    begin_step(c);
    for (int stage = 0; stage < 4; stage++) {
        const int wrong = evaluate_rates(c, u, extra);
        if (wrong) return -wrong;
        add_stage(c, weights[stage], h);
        const int bad = stage < 3 ? move_to(c, shares[stage] * h, c->qd, c->qdd, c->law_rates)
                                  : move_to(c, h / 6, c->slopes, c->slopes + dofs, c->slopes + 2 * dofs);
        if (bad) return bad;
    }
    if (c->blob.counts.closures) loops_close(c);
    stop_at_limits(c);
    return 0;
}

int core_runge_kutta(core *c, const real *u, const real *extra, real h, int32_t steps)
{
    memset(c->work, 0, 4 * sizeof(real));
    for (; steps > 0; steps--) {
        const int bad = one_step(c, u, extra, h);
        if (bad) return bad;
    }
    return 0;
}
