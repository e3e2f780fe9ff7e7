#include "straight.h"

#include "../../kinematics/joint_variables.h"

#include <string.h>

int straight_applies(const core *c)
{
    const blob_counts *n = &c->blob.counts;
    for (int32_t m = 0; m < n->muscles; m++)
        if (c->blob.muscle_points[m] < 2) return 0;
    return !n->wraps && !n->surfaces && !n->pulleys && !n->branches && !n->conditions && !n->moves && !n->path_terms &&
           !n->bends;
}

void straight_place(core *c)
{
    const blob_view *b = &c->blob;
    for (int32_t k = 0; k < b->counts.points; k++)
        tree_point(c, b->point_frame[k], b->point_position + 3 * k, c->point + 3 * k);
}

void straight_move(core *c)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    straight_place(c);
    memset(c->jacobian, 0, (size_t)c->blob.counts.muscles * dofs * sizeof(real));
    for (int32_t m = 0, k = 0; m < c->blob.counts.muscles; m++, k++) {
        real *J = c->jacobian + (size_t)m * dofs, *row = c->is_driven ? c->row : J, length = number(0);
        if (c->is_driven) memset(row, 0, (size_t)c->blob.counts.variables * sizeof(real));
        for (const int32_t last = k + c->blob.muscle_points[m] - 1; k < last; k++)
            length += agreed(c, value_of(c->fixed_length[k]) >= 0) ? c->fixed_length[k] : add_segment(c, k, row);
        c->lengths[m] = length;
        if (c->is_driven) variables_fold(c, row, J);
    }
}
