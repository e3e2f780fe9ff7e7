#include "reference_parts.h"

#include <math.h>

int native_has_nan(const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (isnan(values[i]))
            return 1;
    return 0;
}

int native_parts_place(reference_part *parts, const struct native_parts *from, size_t r)
{
    const size_t count = from->count;
    uint64_t used = 0;
    if (!count || !r || r > 4096 || native_has_nan(from->begin, count) || native_has_nan(from->duration, count) ||
        native_has_nan(from->data, from->number_count))
        return 1;
    for (size_t i = 0; i < count; i++) {
        reference_part *part = &parts[i];
        *part = (reference_part){.kind = from->kind[i],
                                 .r = r,
                                 .duration = from->duration[i],
                                 .segments = from->segments[i],
                                 .powers = from->powers[i],
                                 .data = from->data + used};
        const uint64_t length = reference_part_length(part);
        if (!length || length > from->number_count - used)
            return 1;
        used += length;
    }
    return used != from->number_count;
}
