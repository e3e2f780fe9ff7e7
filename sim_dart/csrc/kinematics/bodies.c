#include "bodies.h"

#include "../math/vectors.h"
#include "joint_variables.h"

#include <string.h>

void bodies_links(core *c)
{
    for (int32_t i = 0; i < c->blob.counts.frames; i++) {
        const int32_t parent = c->blob.parent[i];
        for (int k = 0; k < 3; k++)
            c->link[3 * i + k] = c->origin[3 * i + k] - (parent < 0 ? number(0) : c->origin[3 * parent + k]);
    }
}

/* Compute the moments of mass of frame i about its origin: m r and R I R' + m (r.r 1 - r r'). */
static void place_inertia(core *c, int32_t i)
{
    const real *R = c->rotation + 9 * i, *I = c->blob.inertia + 6 * i, m = c->blob.mass[i];
    const real local[9] = {I[0], I[3], I[4], I[3], I[1], I[5], I[4], I[5], I[2]};
    real *moment = c->moment + 9 * i, *centre = c->centre + 3 * i, r[3], RI[9];
    rotate3(r, R, c->blob.mass_centre + 3 * i);
    multiply3(RI, R, local);
    const real rr = m * dot3(r, r);
    for (int a = 0; a < 3; a++) {
        centre[a] = m * r[a];
        for (int b = 0; b < 3; b++)
            moment[3 * a + b] = dot3(RI + 3 * a, R + 3 * b) - m * r[a] * r[b] + (a == b ? rr : number(0));
    }
}

/* Return whether a frame has no inertia, as between the motions of one joint. */
static int is_empty(const core *c, int32_t i)
{
    const real *I = c->blob.inertia + 6 * i;
    const truth is_massless = (c->blob.mass[i] == 0) & (I[0] == 0) & (I[1] == 0) & (I[2] == 0);
    return agreed(c, is_massless & (I[3] == 0) & (I[4] == 0) & (I[5] == 0));
}

void bodies_inertias(core *c)
{
    for (int32_t i = 0; i < c->blob.counts.frames; i++) {
        if (!is_empty(c, i)) {
            place_inertia(c, i);
            continue;
        }
        memset(c->centre + 3 * i, 0, 3 * sizeof(real));
        memset(c->moment + 9 * i, 0, 9 * sizeof(real));
    }
}

/* Add the contribution of the second derivatives of the motions to the drift. */
static void add_second_derivatives(core *c)
{
    for (int32_t i = 0; i < c->blob.counts.frames; i++) {
        const real bend = c->bend[c->blob.coordinate[i]];
        real *drift = c->drift + 6 * i + (c->blob.motion[i] == ROTATION ? 0 : 3);
        for (int k = 0; k < 3; k++) drift[k] += bend * c->axis[3 * i + k];
    }
}

void bodies_velocities(core *c, const real *qd)
{
    static const real rest[3]; /* zeros */
    if (c->is_driven) qd = variables_rates(c, qd);
    for (int32_t i = 0; i < c->blob.counts.frames; i++) {
        const int32_t parent = c->blob.parent[i];
        const int turns = c->blob.motion[i] == ROTATION;
        const real rate = qd[c->blob.coordinate[i]], *r = c->link + 3 * i;
        const real *w = parent < 0 ? rest : c->spin + 3 * parent;
        real *spin = c->spin + 3 * i, *velocity = c->velocity + 3 * i, *slide = c->slide + 3 * i;
        for (int k = 0; k < 3; k++) slide[k] = rate * c->axis[3 * i + k];
        memcpy(spin, w, 3 * sizeof(real));
        memcpy(velocity, parent < 0 ? rest : c->velocity + 3 * parent, 3 * sizeof(real));
        add_cross3(velocity, w, r);
        add3(turns ? spin : velocity, slide);

        real *drift = c->drift + 6 * i;
        memset(drift, 0, 6 * sizeof(real));
        add_centripetal(drift + 3, w, r);
        add_cross3(turns ? drift : drift + 3, w, slide);
        if (!turns) add_cross3(drift + 3, w, slide); /* Coriolis acceleration: factor 2 */
    }
    if (c->is_driven) add_second_derivatives(c);
}
