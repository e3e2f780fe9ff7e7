/* References of any kind: their size, and their evaluation at one or several times. */
#include "references.h"

uint64_t reference_part_length(const reference_part *part)
{
    const uint64_t S = part->segments, O = part->powers, r = part->r;
    if (part->kind == REFERENCE_SPLINES)
        return S >= 1 && S <= 1000000 && O <= 64 ? S + 1 + S * O * 3 * r + 2 * r : 0;
    if (part->kind >= REFERENCE_KINDS || !(part->duration > 0))
        return 0;
    return part->kind == REFERENCE_ROSE ? 3 * r + 3 : 2 * r;
}

static void part_at(const reference_part *part, real t, real *rows)
{
    static void (*const evaluate[REFERENCE_KINDS])(const reference_part *, real, real *) = {
        [REFERENCE_SPLINES] = splines_at, [REFERENCE_ROSE] = rose_at, [REFERENCE_APPROACH] = approach_at};
    evaluate[part->kind](part, t, rows);
}

void reference_evaluate(const reference_part *parts, const real *begins, size_t part_count, size_t time_count,
                        const real *times, real *rows)
{
    for (size_t k = 0; k < time_count; k++) {
        size_t i = 0;
        while (i + 1 < part_count && times[k] >= begins[i + 1]) i++;
        part_at(parts + i, times[k] - begins[i], rows + k * 3 * parts->r);
    }
}
