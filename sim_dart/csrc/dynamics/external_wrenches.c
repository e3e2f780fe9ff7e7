/* External loads: generalised forces from the caller, and wrenches on points of frames. */
#include "external_wrenches.h"

#include "../kinematics/points.h"
#include "../kinematics/joint_variables.h"
#include "spatial.h"

#include <string.h>

int core_external_wrenches(core *c, int32_t count, const int32_t *frame, const real *point, const real *wrench)
{
    for (int32_t k = 0; k < count; k++)
        if (frame[k] < -1 || frame[k] >= c->blob.counts.frames) return 1 + k;
    c->externals = count, c->external_frame = frame, c->external_point = point, c->external_wrench = wrench;
    return 0;
}

/* Add J'w: all motions between the point and the world contribute. */
static void add_wrench(const core *c, int32_t frame, const real local[3], const real wrench[6], real *forces)
{
    real point[3], velocity[3];
    tree_point(c, frame, local, point);
    for (int32_t i = frame; i >= 0; i = c->blob.parent[i]) {
        tree_point_velocity(c, i, point, velocity);
        real force = dot3(velocity, wrench);
        if (c->blob.motion[i] == ROTATION) force += dot3(c->axis + 3 * i, wrench + 3);
        forces[c->blob.coordinate[i]] += force;
    }
}

void external_wrenches_add(core *c, const real *extra)
{
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) c->outer[j] = extra ? extra[j] : number(0);
    real *forces = c->outer;
    if (c->is_driven && c->externals) {
        forces = c->row;
        memset(forces, 0, (size_t)c->blob.counts.variables * sizeof(real));
        memcpy(forces, c->outer, (size_t)c->blob.counts.dofs * sizeof(real));
    }
    for (int32_t k = 0; k < c->externals; k++)
        if (!is_zero_wrench(c->external_wrench + 6 * k))
            add_wrench(c, c->external_frame[k], c->external_point + 3 * k, c->external_wrench + 6 * k, forces);
    if (forces != c->outer) variables_fold(c, forces, c->outer);
}
