/* Task points: where they are, and how q moves them. */
#include "state.h"

#include <string.h>

void tasks_move(core *c)
{
    for (int32_t k = 0; k < c->blob.counts.tasks; k++)
        tree_point(c, c->blob.task_frame[k], c->blob.task_position + 3 * k, c->task_position + 3 * k);
}

void core_task_jacobian(core *c)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    memset(c->task_jacobian, 0, 3 * (size_t)c->blob.counts.tasks * dofs * sizeof(double));
    for (int32_t k = 0; k < c->blob.counts.tasks; k++)
        for (int32_t j = c->blob.task_frame[k]; j >= 0; j = c->blob.parent[j]) {
            const size_t column = (size_t)c->blob.coordinate[j];
            double velocity[3];
            tree_point_velocity(c, j, c->task_position + 3 * k, velocity);
            for (int row = 0; row < 3; row++)
                c->task_jacobian[(3 * (size_t)k + (size_t)row) * dofs + column] += velocity[row];
        }
}
