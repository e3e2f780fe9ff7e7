/* Time derivatives of q, qd and law_states: all terms are explicit. The Runge-Kutta method evaluates them at
   its stages, and solvers of other tools in model exchange. */
#include "state_rates.h"

#include "../dynamics/external_wrenches.h"
#include "../dynamics/limit_forces.h"
#include "../kinematics/joint_variables.h"
#include "../laws/laws.h"

void state_rates_accelerate(core *c, const real *extra)
{
    const blob_view *b = &c->blob;
    external_wrenches_add(c, extra);
    const real *rates = c->is_driven ? variables_rates(c, c->qd) : c->qd;
    real *load = c->is_driven ? c->row : c->load;
    for (int32_t j = 0; j < b->counts.variables; j++) {
        const real applied = j < b->counts.dofs ? c->torques[j] + c->outer[j] : 0;
        load[j] = applied - b->damping[j] * rates[j] - b->stiffness[j] * (c->at[j] - b->rest[j]);
    }
    for (int32_t l = 0; l < b->counts.limit_forces; l++) {
        const limit_force f = limit_force_at(c, l);
        load[b->limit_variable[l]] -= f.damping * rates[b->limit_variable[l]] + f.stiffness * f.beyond;
    }
    if (c->is_driven) variables_fold(c, load, c->load);
    core_accelerate(c, c->qd, c->load, b->armature);
}

int state_rates_evaluate(core *c, const real *u, const real *extra)
{
    const int bad = muscles_pull(c, u);
    if (bad) return bad;
    state_rates_accelerate(c, extra);
    return c->has_laws ? core_law_rates(c, u) : 0;
}

void state_rates_add_work(core *c, real h)
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
