/* Steps of the plant: muscles, forward dynamics, semi-implicit Euler, joint limits. */
#include "law.h"
#include "state.h"

#include <math.h>

/* Damping and springs act at the end of the step, to first order: h D + h^2 K beside M. */
static void accelerate(core *c, const double *extra, double h)
{
    const blob_view *b = &c->blob;
    for (int32_t j = 0; j < b->counts.dofs; j++) {
        c->armature[j] = h * (b->damping[j] + h * b->stiffness[j]);
        c->load[j] = c->torques[j] + (extra ? extra[j] : 0) - b->damping[j] * c->qd[j] -
                     b->stiffness[j] * (c->q[j] + h * c->qd[j] - b->rest[j]);
    }
    core_accelerate(c, c->qd, c->load, c->armature);
}

static int all_finite(const double *values, int32_t count)
{
    for (int32_t k = 0; k < count; k++)
        if (!isfinite(values[k])) return 0;
    return 1;
}

/* Muscles remember with the lengthening that the step ends with. */
static int advance_muscles(core *c, const double *u, double h)
{
    core_rates(c, c->qd);
    core_advance(c, u, h);
    return all_finite(c->law_states, c->blob.law_states);
}

int core_step(core *c, const double *u, const double *extra, double h, int32_t steps)
{
    const int32_t dofs = c->blob.counts.dofs;
    for (; steps > 0; steps--) {
        int bad = c->has_laws ? core_drive(c, c->qd, u) : core_pull(c, u);
        if (bad) return -bad;
        accelerate(c, extra, h);
        for (int32_t j = 0; j < dofs; j++) c->qd[j] += h * c->qdd[j];
        limits_keep(c, h);
        if (c->has_laws && !advance_muscles(c, u, h)) return dofs + 1;
        for (int32_t j = 0; j < dofs; j++) c->q[j] += h * c->qd[j];
        bad = core_move_checked(c, c->q, c->qd);
        if (bad) return bad;
    }
    return 0;
}
