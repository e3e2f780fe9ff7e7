/* Piecewise polynomials of time: positions, velocities and accelerations have separate polynomials. */
#include "references.h"

#include <string.h>

static void rest_at(const reference_part *part, const real *position, real *rows)
{
    memset(rows, 0, 3 * part->r * sizeof *rows);
    memcpy(rows, position, part->r * sizeof *rows);
}

/* Return the last segment that begins at t or before. */
static size_t segment_of(const reference_part *part, real t)
{
    size_t low = 0, high = part->segments;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (t >= part->data[middle])
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Evaluate y = sum_k c_k (t - t_i)^k on the segment from t_i on, by Horner's rule. */
void splines_at(const reference_part *part, real t, real *rows)
{
    const size_t r = part->r, S = part->segments, O = part->powers, width = 3 * r;
    const real *times = part->data, *coefficients = times + S + 1, *first = coefficients + S * O * width;
    if (t < 0 || t > part->duration) {
        rest_at(part, t < 0 ? first : first + r, rows);
        return;
    }
    const size_t segment = segment_of(part, t);
    const real *c = coefficients + segment * O * width, since = t - times[segment];
    memset(rows, 0, width * sizeof *rows);
    for (size_t k = O; k-- > 0;)
        for (size_t i = 0; i < width; i++)
            rows[i] = rows[i] * since + c[k * width + i];
}
