/* Steps of the plant: muscles, forward dynamics, semi-implicit Euler, joint limits. */
#include "state.h"

#include <math.h>

/* Damping acts on the velocity that a step ends with, to first order: h D beside M, -D qd on the right. */
static void accelerate(core *c, const double *extra, double h)
{
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) {
        c->armature[j] = h * c->blob.damping[j];
        c->load[j] = c->torques[j] + (extra ? extra[j] : 0) - c->blob.damping[j] * c->qd[j];
    }
    core_accelerate(c, c->qd, c->load, c->armature);
}

int core_step(core *c, const double *f, const double *extra, double h, int32_t steps)
{
    const int32_t dofs = c->blob.counts.dofs;
    for (; steps > 0; steps--) {
        int bad = core_pull(c, f);
        if (bad) return -bad;
        accelerate(c, extra, h);
        for (int32_t j = 0; j < dofs; j++) c->qd[j] += h * c->qdd[j];
        limits_keep(c, h);
        for (int32_t j = 0; j < dofs; j++) c->q[j] += h * c->qd[j];
        bad = core_move_checked(c, c->q, c->qd);
        if (bad) return bad;
    }
    return 0;
}
