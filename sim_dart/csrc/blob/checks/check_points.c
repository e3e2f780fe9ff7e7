#include "check_points.h"

#include "../message.h"

#include <math.h>

int all_finite(const real *values, size_t count)
{
    for (size_t k = 0; k < count; k++)
        if (!isfinite(values[k])) return 0;
    return 1;
}

int check_points(const char *label, const int32_t *frame, const real *position, int32_t points,
                 int32_t dofs, char *message, size_t capacity)
{
    for (int32_t k = 0; k < points; k++) {
        if (frame[k] < -1 || frame[k] >= dofs)
            return reject(message, capacity, "%s %d: unknown frame %d", label, (int)k, (int)frame[k]);
        if (!all_finite(position + 3 * k, 3))
            return reject(message, capacity, "%s %d: its position is not finite", label, (int)k);
    }
    return 0;
}
