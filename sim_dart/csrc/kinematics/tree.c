/* Kinematics of the tree: poses of all frames, and velocities of points. */
#include "tree.h"

#include "../math/elementary.h"
#include "../math/vectors.h"
#include "points.h"
#include "joint_variables.h"

#include <string.h>

/* Compute R1 = R0 [a], R2 = R0 [a][a]. With these, Rodrigues' formula needs two products and two sums per
   entry. */
void tree_prepare(core *c)
{
    for (int32_t i = 0; i < c->blob.counts.frames; i++) {
        if (c->blob.motion[i] != ROTATION) continue;
        const real *a = c->blob.axis + 3 * i;
        const real skew[9] = {number(0), -a[2], a[1], a[2], number(0), -a[0], -a[1], a[0], number(0)};
        multiply3(c->rotation_sin + 9 * i, c->blob.offset_rotation + 9 * i, skew);
        multiply3(c->rotation_cos + 9 * i, c->rotation_sin + 9 * i, skew);
    }
}

void tree_direction(const core *c, int32_t frame, const real local[3], real world[3])
{
    if (frame < 0)
        memcpy(world, local, 3 * sizeof(real));
    else
        rotate3(world, c->rotation + 9 * frame, local);
}

static void frame_rotation(const core *c, int32_t i, real q, real R[9])
{
    const real *R0 = c->blob.offset_rotation + 9 * i;
    if (c->blob.motion[i] != ROTATION) {
        memcpy(R, R0, 9 * sizeof(real));
        return;
    }
    real s, cosine;
    sine_cosine(q, &s, &cosine);
    const real v = 1 - cosine;
    for (int k = 0; k < 9; k++) R[k] = R0[k] + s * c->rotation_sin[9 * i + k] + v * c->rotation_cos[9 * i + k];
}

void tree_move(core *c, const real *q)
{
    memcpy(c->at, q, (size_t)c->blob.counts.dofs * sizeof(real));
    c->is_factored = 0;
    if (c->is_driven) variables_move(c);
    for (int32_t i = 0; i < c->blob.counts.frames; i++) {
        const int32_t parent = c->blob.parent[i];
        const real qi = c->at[c->blob.coordinate[i]];
        real local[9], *R = c->rotation + 9 * i, *origin = c->origin + 3 * i, *axis = c->axis + 3 * i;
        tree_point(c, parent, c->blob.offset_position + 3 * i, origin);
        frame_rotation(c, i, qi, local);
        if (parent < 0)
            memcpy(R, local, sizeof local);
        else
            multiply3(R, c->rotation + 9 * parent, local);
        rotate3(axis, R, c->blob.axis + 3 * i);
        if (c->blob.motion[i] == TRANSLATION)
            for (int k = 0; k < 3; k++) origin[k] += qi * axis[k];
    }
}
