/* Task coordinates: positions of points and orientations of links, and their derivatives by q. */
#include "tasks.h"

#include "../math/elementary.h"
#include "bodies.h"
#include "points.h"
#include "joint_variables.h"

#include <string.h>

/* Compute the angles of R = Rx(alpha) Ry(beta) Rz(gamma). */
static void angles_of(const real R[9], real angles[3])
{
    angles[0] = arc_tangent(-R[5], R[8]);
    angles[1] = arc_sine(R[2]);
    angles[2] = arc_tangent(-R[1], R[0]);
}

/* Compute the rates of the angles for an angular velocity w in the world:
     w = alpha' x + beta' Rx y + gamma' Rx Ry z, solved for the rates. */
static void angle_rates(const real angles[3], const real w[3], real rates[3])
{
    real sa, ca, sb, cb;
    sine_cosine(angles[0], &sa, &ca);
    sine_cosine(angles[1], &sb, &cb);
    rates[1] = ca * w[1] + sa * w[2];
    rates[2] = (ca * w[2] - sa * w[1]) / cb;
    rates[0] = w[0] - sb * rates[2];
}

void tasks_move(core *c)
{
    for (int32_t k = 0; k < c->blob.counts.tasks; k++) {
        const int32_t frame = c->blob.task_frame[k];
        const real *local = c->blob.task_rotation + 9 * k;
        real *values = c->task_values + 3 * k, R[9];
        if (c->blob.task_kind[k] == TASK_POINT) {
            tree_point(c, frame, c->blob.task_position + 3 * k, values);
        } else if (frame < 0) {
            angles_of(local, values);
        } else {
            multiply3(R, c->rotation + 9 * frame, local);
            angles_of(R, values);
        }
    }
}

static void task_rates(const core *c, int32_t task, int32_t frame, real rates[3])
{
    const real *values = c->task_values + 3 * task;
    if (c->blob.task_kind[task] == TASK_POINT)
        tree_point_velocity(c, frame, values, rates);
    else if (c->blob.motion[frame] == ROTATION)
        angle_rates(values, c->axis + 3 * frame, rates);
    else
        memset(rates, 0, 3 * sizeof(real));
}

void core_task_jacobian(core *c)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    const size_t width = c->is_driven ? (size_t)c->blob.counts.variables : dofs;
    for (int32_t k = 0; k < c->blob.counts.tasks; k++) {
        real *J = c->task_jacobian + 3 * (size_t)k * dofs, *rows = c->is_driven ? c->row : J;
        memset(rows, 0, 3 * width * sizeof(real));
        for (int32_t j = c->blob.task_frame[k]; j >= 0; j = c->blob.parent[j]) {
            const size_t column = (size_t)c->blob.coordinate[j];
            real rates[3];
            task_rates(c, k, j, rates);
            for (size_t row = 0; row < 3; row++)
                rows[row * width + column] += rates[row];
        }
        for (size_t row = 0; row < 3 && c->is_driven; row++) variables_fold(c, rows + row * width, J + row * dofs);
    }
}

/* Compute the derivative of angle_rates at angular acceleration alpha, solved from
     alpha_w = d/dt (alpha' x + beta' Rx y + gamma' Rx Ry z). */
static void angle_accelerations(const real angles[3], const real w[3], const real alpha[3],
                                real out[3])
{
    real sa, ca, sb, cb;
    sine_cosine(angles[0], &sa, &ca);
    sine_cosine(angles[1], &sb, &cb);
    real rates[3];
    angle_rates(angles, w, rates);
    const real second[3] = {number(0), ca, sa}, third[3] = {sb, -sa * cb, ca * cb};
    const real first[3] = {number(1), number(0), number(0)};
    /* rotation of the axes: x is fixed, y turns with alpha', z with alpha' x + beta' y */
    real left[3] = {alpha[0], alpha[1], alpha[2]}, turn[3], change[3];
    for (int k = 0; k < 3; k++) turn[k] = rates[0] * first[k];
    cross3(change, turn, second);
    for (int k = 0; k < 3; k++) left[k] -= rates[1] * change[k], turn[k] += rates[1] * second[k];
    cross3(change, turn, third);
    for (int k = 0; k < 3; k++) left[k] -= rates[2] * change[k];
    angle_rates(angles, left, out);
}

void core_task_bias(core *c, const real *qd)
{
    bodies_links(c);
    bodies_velocities(c, qd);
    for (int32_t i = 0; i < c->blob.counts.frames; i++) {
        real *acceleration = c->acceleration + 6 * i;
        bodies_parent_acceleration(c, i, c->acceleration, acceleration);
        for (int k = 0; k < 6; k++) acceleration[k] += c->drift[6 * i + k];
    }
    memset(c->task_bias, 0, 3 * (size_t)c->blob.counts.tasks * sizeof(real));
    for (int32_t k = 0; k < c->blob.counts.tasks; k++) {
        const int32_t frame = c->blob.task_frame[k];
        real *bias = c->task_bias + 3 * k;
        if (frame < 0) continue;
        const real *spin = c->spin + 3 * frame, *acceleration = c->acceleration + 6 * frame;
        if (c->blob.task_kind[k] == TASK_ORIENTATION) {
            angle_accelerations(c->task_values + 3 * k, spin, acceleration, bias);
            continue;
        }
        real arm[3];
        for (int a = 0; a < 3; a++) arm[a] = c->task_values[3 * k + a] - c->origin[3 * frame + a];
        memcpy(bias, acceleration + 3, 3 * sizeof(real));
        add_cross3(bias, acceleration, arm);
        add_centripetal(bias, spin, arm);
    }
}
