/* ideal: f = max(u, 0) */
#include "law.h"

static real ideal_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)k, (void)x, (void)l, (void)v;
    return u;
}

TENSION_LAW(ideal) = {
    .constants = LAW_OWN,
    .tension = ideal_tension,
};
