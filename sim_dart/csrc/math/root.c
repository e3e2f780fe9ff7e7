#include "root.h"

#include "elementary.h"

#include <math.h>

#define MAX_ROOT_STEPS 100
#define LONG_STEPS 8 /* number of steps after which a slow step is a bisection */

/* Apply Newton's method once more, so that the tangent converges, too. */
static real refine_root(root_function *g, const void *data, real z)
{
    real slope;
    const real value = g(data, z, &slope);
    return slope == 0 ? z : z - value / slope;
}

real bracketed_root(root_function *g, const void *data, real low, real high, real guess,
                    real tolerance)
{
    real z = guess, last = high - low;
    int knows_low = 0;
    for (int i = 0; i < MAX_ROOT_STEPS; i++) {
        real slope;
        const real value = g(data, z, &slope);
        if (value == 0) return z;
        if (!knows_low && !(value_of(z - value / slope) > value_of(low))) {
            real unused;
            if (value_of(g(data, low, &unused)) >= 0) return low;
            knows_low = 1;
        }
        if (value_of(value) < 0)
            low = z;
        else
            high = z;
        const real step = value / slope;
        const int is_slow = !(value_of(fabs(step)) <= value_of(last / 2));
        const real to = is_slow ? z - 2 * step : z - step;
        const int is_inside = value_of(to) >= value_of(low) && value_of(to) <= value_of(high);
        if (value_of(fabs(step)) <= value_of(tolerance)) {
            z = smaller(larger(z - step, low), high);
            return HAS_TANGENT ? refine_root(g, data, z) : z;
        }
        const real next = is_inside && !(is_slow && i >= LONG_STEPS) ? to : (low + high) / 2;
        last = fabs(next - z);
        if (next == z) return z;
        z = next;
    }
    return z;
}
