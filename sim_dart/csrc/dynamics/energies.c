/* Energies and momenta of the bodies at the last q. */
#include "../blob/state.h"
#include "../kinematics/bodies.h"
#include "../math/vectors.h"
#include "limit_forces.h"

#include <string.h>

/* Compute the momentum of the bodies of frame i: linear, and angular about the origin of the frame. */
static void momentum_of(const core *c, int32_t i, real linear[3], real angular[3])
{
    const real *w = c->spin + 3 * i, *v = c->velocity + 3 * i, *first = c->centre + 3 * i;
    for (int k = 0; k < 3; k++) linear[k] = c->blob.mass[i] * v[k];
    add_cross3(linear, w, first);
    rotate3(angular, c->moment + 9 * i, w);
    add_cross3(angular, first, v);
}

static void add_body(core *c, int32_t i)
{
    const real *origin = c->origin + 3 * i, *first = c->centre + 3 * i, m = c->blob.mass[i];
    real linear[3], angular[3], place[3];
    momentum_of(c, i, linear, angular);
    c->energies[0] += 0.5 * (dot3(c->velocity + 3 * i, linear) + dot3(c->spin + 3 * i, angular));
    for (int k = 0; k < 3; k++) place[k] = m * origin[k] + first[k];
    c->energies[1] -= dot3(c->blob.gravity, place);
    add3(c->momenta, linear);
    add3(c->momenta + 3, angular);
    add_cross3(c->momenta + 3, origin, linear);
}

void core_energies(core *c, const real *qd)
{
    memset(c->energies, 0, 3 * sizeof(real));
    memset(c->momenta, 0, 6 * sizeof(real));
    bodies_links(c);
    bodies_inertias(c);
    bodies_velocities(c, qd);
    for (int32_t i = 0; i < c->blob.counts.frames; i++) add_body(c, i);
    const real *rates = c->is_driven ? c->moved : qd;
    for (int32_t j = 0; j < c->blob.counts.variables; j++) {
        const real bent = c->at[j] - c->blob.rest[j];
        c->energies[2] += 0.5 * c->blob.stiffness[j] * bent * bent;
        c->energies[0] += 0.5 * c->blob.armature[j] * rates[j] * rates[j];
    }
    for (int32_t l = 0; l < c->blob.counts.limit_forces; l++)
        if (!is_soft_limit(c, l)) c->energies[2] += limit_force_at(c, l).energy;
}
