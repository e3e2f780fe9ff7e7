/* Accelerations of frames, and of points on them. */
#include "specific_force.h"

#include "../kinematics/bodies.h"
#include "../kinematics/joint_variables.h"
#include "../kinematics/points.h"

void accelerate_frames(core *c, real *rates)
{
    if (c->is_driven)
        variables_follow(c, c->qdd, rates);
    else
        rates = c->qdd;
    for (int32_t f = 0; f < c->blob.counts.frames; f++) {
        real *a = c->acceleration + 6 * f;
        bodies_parent_acceleration(c, f, c->acceleration, a);
        for (int k = 0; k < 6; k++) a[k] += c->drift[6 * f + k];
        const real rate = rates[c->blob.coordinate[f]];
        for (int k = 0; k < 3; k++) a[(c->blob.motion[f] == ROTATION ? 0 : 3) + k] += rate * c->axis[3 * f + k];
    }
}

void specific_force(const core *c, int32_t frame, const real r[3], real s[3])
{
    const real *a = c->acceleration + 6 * frame;
    for (int k = 0; k < 3; k++) s[k] = a[3 + k] - c->blob.gravity[k];
    add_cross3(s, a, r);
    add_centripetal(s, c->spin + 3 * frame, r);
}
