/* A straight minimum-jerk path from rest to rest: y = a + (b - a) s(t/T). */
#include "references.h"

#include "../../../sim_dart/csrc/math/quintic_step.h"

void quintic(real t, real T, real s[3])
{
    const real u = t / T;
    s[0] = t >= T;
    s[1] = s[2] = 0;
    if (t <= 0 || t >= T)
        return;
    s[0] = quintic_step(u);
    s[1] = quintic_step_rate(u) / T;
    s[2] = quintic_step_curvature(u) / (T * T);
}

void approach_at(const reference_part *part, real t, real *rows)
{
    const real *start = part->data, *displacement = start + part->r;
    real s[3];
    quintic(t, part->duration, s);
    for (size_t i = 0; i < part->r; i++)
        for (size_t d = 0; d < 3; d++)
            rows[d * part->r + i] = s[d] * displacement[i] + (d ? 0 : start[i]);
}
