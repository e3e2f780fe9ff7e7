/* M = L' D L, from the last coordinate to the first (Featherstone). Entries between coordinates on different
   branches are and stay zero. L is stored below the diagonal, 1 / D on the diagonal. */
#include "dense.h"

#include "../cable_friction/cable_friction.h"
#include "../optional_parts.h"
#include "inverse.h"

void dense_factor(core *c, const real *armature)
{
    const size_t n = (size_t)c->blob.counts.dofs;
    inverse_mass(c, armature, c->dense);
    if (USES_CABLE_FRICTION && c->is_rubbing) cable_friction_resist(c, c->dense);
    for (size_t k = n; k-- > 0;) {
        real *row = c->dense + k * n;
        row[k] = 1 / row[k];
        for (size_t i = k; i-- > 0;) {
            if (row[i] == 0) continue;
            const real share = row[i] * row[k];
            for (size_t j = 0; j <= i; j++) c->dense[i * n + j] -= share * row[j];
            row[i] = share;
        }
    }
}

void dense_solve(const core *c, real *x)
{
    const size_t n = (size_t)c->blob.counts.dofs;
    for (size_t i = n; i-- > 0;)
        for (size_t j = 0; j < i; j++) x[j] -= c->dense[i * n + j] * x[i];
    for (size_t i = 0; i < n; i++) {
        x[i] *= c->dense[i * n + i];
        for (size_t j = 0; j < i; j++) x[i] -= c->dense[i * n + j] * x[j];
    }
}

void dense_accelerate(core *c, const real *qd, const real *tau, const real *armature)
{
    inverse_fall(c, qd, c->qdd);
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) c->qdd[j] = tau[j] - c->qdd[j];
    dense_factor(c, armature);
    dense_solve(c, c->qdd);
}
