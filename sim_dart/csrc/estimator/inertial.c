/* An IMU with the axes R on a frame with angular velocity w, at r from the origin, which has the
   acceleration a:

     gyroscope       R'w + bias
     accelerometer   R'(a + alpha x r + w x (w x r) - g) + bias

   Derivatives by q_j, which turns frames about a_j:  d(R'w) = R'(w_j x a_j),  d(R's) = R'(s x a_j), with w_j
   the angular velocity of frame j. In addition, the acceleration of a point changes by J dqdd. qdd changes
   with the state according to the transition matrix of the last step, (A - I)/h; noise of accelerations is
   also noise of the accelerometer. The effect of velocities on w x (w x r) and J' qd is neglected. */
#include "inertial.h"

#include "../kinematics/bodies.h"
#include "../kinematics/joint_variables.h"
#include "../kinematics/points.h"
#include "../sensors/specific_force.h"
#include "correct.h"

#include <string.h>

/* Compute the derivatives of a gyroscope, along an axis in the world, by q and qd. */
static void fill_turning(estimator *e, int32_t frame, const real along[3])
{
    core *c = e->core;
    real *by_q = e->wide_row, *by_qd = by_q + e->variables, turned[3];
    memset(by_q, 0, 2 * e->variables * sizeof(real));
    for (int32_t j = frame; j >= 0; j = c->blob.parent[j]) {
        if (c->blob.motion[j] != ROTATION) continue;
        cross3(turned, c->spin + 3 * j, c->axis + 3 * j);
        by_q[c->blob.coordinate[j]] += dot3(turned, along);
        by_qd[c->blob.coordinate[j]] += dot3(c->axis + 3 * j, along);
    }
    variables_fold(c, by_q, e->row);
    variables_fold(c, by_qd, e->row + e->n);
}

/* Compute the derivatives of an accelerometer at a point, along an axis, by q, qd and w; return the variance
   due to noise of qdd. */
static real fill_force(estimator *e, int32_t frame, const real point[3], const real along[3], const real force[3])
{
    core *c = e->core;
    const size_t n = e->n;
    real *by_q = e->wide_row, *by_qdd = by_q + e->variables, *row = e->row, *J = row + 3 * n, rate[3], noise = 0;
    memset(by_q, 0, 2 * e->variables * sizeof(real));
    for (int32_t j = frame; j >= 0; j = c->blob.parent[j]) {
        const size_t x = (size_t)c->blob.coordinate[j];
        tree_point_velocity(c, j, point, rate);
        by_qdd[x] += dot3(rate, along);
        if (c->blob.motion[j] != ROTATION) continue;
        cross3(rate, force, c->axis + 3 * j);
        by_q[x] += dot3(rate, along);
    }
    memset(row, 0, 3 * n * sizeof(real));
    variables_fold(c, by_q, row);
    variables_fold(c, by_qdd, J);
    for (size_t i = 0; i < n; i++) {
        const real share = J[i] / e->step, *A = e->transition + (n + i) * 3 * n, white = J[i] * e->acceleration_noise[i];
        for (size_t k = 0; k < 3 * n; k++) row[k] += share * (A[k] - (k == n + i ? 1 : 0));
        noise += white * white / e->step;
        for (size_t k = 0; k < n; k++) noise += J[i] * e->jitter[i * n + k] * J[k];
    }
    return noise;
}

static void take_gyroscope(estimator *e, size_t unit, const real axes[9], const real *spin)
{
    const real noise = e->gyroscope_noise[unit], *z = e->gyroscope + 3 * unit;
    const size_t bias = 3 * e->n + 6 * unit;
    for (size_t k = 0; k < 3 && is_measured(noise); k++) {
        const real along[3] = {axes[k], axes[3 + k], axes[6 + k]};
        if (!is_number(z[k])) continue;
        fill_turning(e, e->imu_frame[unit], along);
        estimator_take(e, z + k, e->row, 2 * e->n, bias + k, z[k] - dot3(along, spin) - e->state[bias + k],
                       noise * noise);
    }
}

static void take_accelerometer(estimator *e, size_t unit, const real axes[9], const real r[3])
{
    core *c = e->core;
    const int32_t frame = e->imu_frame[unit];
    const real noise = e->accelerometer_noise[unit], *z = e->accelerometer + 3 * unit;
    const size_t bias = 3 * e->n + 6 * unit + 3;
    real point[3], force[3];
    specific_force(c, frame, r, force);
    for (int k = 0; k < 3; k++) point[k] = c->origin[3 * frame + k] + r[k];
    for (size_t k = 0; k < 3 && is_measured(noise); k++) {
        const real along[3] = {axes[k], axes[3 + k], axes[6 + k]};
        if (!is_number(z[k])) continue;
        const real white = fill_force(e, frame, point, along, force);
        estimator_take(e, z + k, e->row, 3 * e->n, bias + k, z[k] - dot3(along, force) - e->state[bias + k],
                       noise * noise + white);
    }
}

void estimator_take_inertial(estimator *e)
{
    core *c = e->core;
    if (!e->i) return;
    bodies_links(c);
    bodies_velocities(c, e->state + e->n);
    accelerate_frames(c, e->rates);
    for (size_t unit = 0; unit < e->i; unit++) {
        const int32_t frame = e->imu_frame[unit];
        real axes[9], r[3];
        multiply3(axes, c->rotation + 9 * frame, e->imu_rotation + 9 * unit);
        rotate3(r, c->rotation + 9 * frame, e->imu_position + 3 * unit);
        take_gyroscope(e, unit, axes, c->spin + 3 * frame);
        take_accelerometer(e, unit, axes, r);
    }
}
