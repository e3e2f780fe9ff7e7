/* Checks of numbers in a blob. */
#ifndef CARDSFLOW_CHECK_POINTS_H
#define CARDSFLOW_CHECK_POINTS_H

#include "../layout.h"

#include <stddef.h>

/* How much squares and products of unit vectors in a blob may be off. */
#define UNIT_TOLERANCE PRECISE(1e-9, 1e-6)

CORE_INSIDE int all_finite(const real *values, size_t count);

/* 0, or a message: points or the like in frames. */
CORE_INSIDE int check_points(const char *what, const int32_t *frame, const real *position, int32_t points,
                             int32_t dofs, char *message, size_t capacity);

#endif
