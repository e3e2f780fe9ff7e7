/* Muscle paths: straight segments through the via points, l = sum |B - A| and L = dl/dq. */
#include "state.h"

#include <math.h>
#include <string.h>

/* Only the motions between the two frames change a segment: those above B move its end, those above A
   its start. With u the direction from A to B, dl/dq_j = u.(dB/dq_j - dA/dq_j).                        */
static double add_segment(const core *c, const double A[3], int32_t a, const double B[3], int32_t b,
                          double *row)
{
    double u[3] = {B[0] - A[0], B[1] - A[1], B[2] - A[2]}, velocity[3];
    const double length = sqrt(dot3(u, u));
    if (length == 0) return 0; /* no direction, so no moment arm either */
    for (int k = 0; k < 3; k++) u[k] /= length;
    while (a != b) {
        if (b > a) {
            tree_point_velocity(c, b, B, velocity);
            row[c->blob.coordinate[b]] += dot3(u, velocity);
            b = c->blob.parent[b];
        } else {
            tree_point_velocity(c, a, A, velocity);
            row[c->blob.coordinate[a]] -= dot3(u, velocity);
            a = c->blob.parent[a];
        }
    }
    return length;
}

void paths_move(core *c)
{
    const blob_view *blob = &c->blob;
    const size_t dofs = (size_t)blob->counts.dofs;
    for (int32_t k = 0; k < blob->counts.points; k++)
        tree_point(c, blob->point_frame[k], blob->point_position + 3 * k, c->point + 3 * k);
    memset(c->jacobian, 0, (size_t)blob->counts.muscles * dofs * sizeof(double));
    int32_t k = 0;
    for (int32_t m = 0; m < blob->counts.muscles; m++, k++) {
        double length = 0;
        for (const int32_t last = k + blob->muscle_points[m] - 1; k < last; k++)
            length += add_segment(c, c->point + 3 * k, blob->point_frame[k], c->point + 3 * (k + 1),
                                  blob->point_frame[k + 1], c->jacobian + (size_t)m * dofs);
        c->lengths[m] = length;
    }
}
