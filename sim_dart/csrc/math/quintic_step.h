/* Quintic step from 0 to 1, whose first and second derivatives vanish at both ends, for 0 <= x <= 1:
     s = 10 x^3 - 15 x^4 + 6 x^5,   s' = 30 x^2 (1 - x)^2,   s'' = 60 x (1 - x) (1 - 2 x) */
#ifndef CARDSFLOW_QUINTIC_STEP_H
#define CARDSFLOW_QUINTIC_STEP_H

#include "../numbers/real.h"

static inline real quintic_step(real x)
{
    return x * x * x * (10 + x * (6 * x - 15));
}

static inline real quintic_step_rate(real x)
{
    return 30 * x * x * (1 - x) * (1 - x);
}

static inline real quintic_step_curvature(real x)
{
    return 60 * x * (1 - x) * (1 - 2 * x);
}

#endif
