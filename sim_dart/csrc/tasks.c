/* Task coordinates: where points are and how links are turned, and how q changes that. */
#include "state.h"

#include <math.h>
#include <string.h>

/* The angles of R = Rx(alpha) Ry(beta) Rz(gamma). */
static void angles_of(const double R[9], double angles[3])
{
    angles[0] = atan2(-R[5], R[8]);
    angles[1] = asin(fmax(-1.0, fmin(1.0, R[2])));
    angles[2] = atan2(-R[1], R[0]);
}

/* Rates of the angles for an angular velocity w in the world:
   w = alpha' x + beta' Rx y + gamma' Rx Ry z, solved for the rates.                                    */
static void angle_rates(const double angles[3], const double w[3], double rates[3])
{
    const double ca = cos(angles[0]), sa = sin(angles[0]), sb = sin(angles[1]), cb = cos(angles[1]);
    rates[1] = ca * w[1] + sa * w[2];
    rates[2] = (ca * w[2] - sa * w[1]) / cb;
    rates[0] = w[0] - sb * rates[2];
}

void tasks_move(core *c)
{
    for (int32_t k = 0; k < c->blob.counts.tasks; k++) {
        const int32_t frame = c->blob.task_frame[k];
        const double *local = c->blob.task_rotation + 9 * k;
        double *values = c->task_values + 3 * k, R[9];
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

static void task_rates(const core *c, int32_t task, int32_t frame, double rates[3])
{
    const double *values = c->task_values + 3 * task;
    if (c->blob.task_kind[task] == TASK_POINT)
        tree_point_velocity(c, frame, values, rates);
    else if (c->blob.motion[frame] == ROTATION)
        angle_rates(values, c->axis + 3 * frame, rates);
    else
        memset(rates, 0, 3 * sizeof(double));
}

void core_task_jacobian(core *c)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    memset(c->task_jacobian, 0, 3 * (size_t)c->blob.counts.tasks * dofs * sizeof(double));
    for (int32_t k = 0; k < c->blob.counts.tasks; k++)
        for (int32_t j = c->blob.task_frame[k]; j >= 0; j = c->blob.parent[j]) {
            const size_t column = (size_t)c->blob.coordinate[j];
            double rates[3];
            task_rates(c, k, j, rates);
            for (size_t row = 0; row < 3; row++)
                c->task_jacobian[(3 * (size_t)k + row) * dofs + column] += rates[row];
        }
}
