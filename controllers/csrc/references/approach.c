/* A straight line of minimum jerk from rest to rest: y = a + (b - a) s(t/T). */
#include "reference.h"

void quintic(real t, real T, real s[3])
{
    const real u = t / T;
    s[0] = t >= T;
    s[1] = s[2] = 0;
    if (t <= 0 || t >= T)
        return;
    s[0] = u * u * u * (10 + u * (6 * u - 15));
    s[1] = 30 * u * u * (1 - u) * (1 - u) / T;
    s[2] = 60 * u * (1 - u) * (1 - 2 * u) / (T * T);
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
