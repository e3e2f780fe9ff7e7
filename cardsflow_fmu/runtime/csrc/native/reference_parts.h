/* The parts of a reference in the settings of a model. */
#ifndef NATIVE_REFERENCE_PARTS_H
#define NATIVE_REFERENCE_PARTS_H

#include "../../../../controllers/csrc/references/references.h"

#include <stddef.h>
#include <stdint.h>

/* The fields PART_FIELDS of settings, and their sizes. */
struct native_parts {
    size_t count, number_count;
    const double *begin, *duration;
    const uint32_t *kind, *segments, *powers;
    const double *data;
};
#define NATIVE_PARTS(s)                                                                                       \
    {(s)->of.parts.count, (s)->of.part_numbers.count, (s)->part_begin, (s)->part_duration, (s)->part_kind,    \
     (s)->part_segments, (s)->part_powers, (s)->part_data}

int native_has_nan(const double *values, size_t count);

/* Compute the parts of a reference with r rows. Return nonzero if they are not valid. */
int native_parts_place(reference_part *parts, const struct native_parts *from, size_t r);

#endif
