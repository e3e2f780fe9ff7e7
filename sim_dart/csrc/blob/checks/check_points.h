/* Checks of numbers in a blob. */
#ifndef CARDSFLOW_CHECK_POINTS_H
#define CARDSFLOW_CHECK_POINTS_H

#include "../layout.h"

#include <stddef.h>

/* Tolerance of the squares and products of unit vectors in a blob. */
#define UNIT_TOLERANCE PRECISE(1e-9, 1e-6)

CORE_INSIDE int all_finite(const real *values, size_t count);

/* Check points, or other vectors that are fixed to frames. Return 0, or write a message and return nonzero. */
CORE_INSIDE int check_points(const char *label, const int32_t *frame, const real *position, int32_t points,
                             int32_t dofs, char *message, size_t capacity);

#endif
