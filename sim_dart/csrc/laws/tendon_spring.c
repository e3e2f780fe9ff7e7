/* tendon_spring: f = k (l - l_high) above l_high, k (l - l_low) below l_low, zero between, plus d l' always,
   as a tendon in MuJoCo: it pushes when it is compressed. */
#include "law.h"

enum { TENDON_STIFFNESS = LAW_OWN, TENDON_LOW, TENDON_HIGH, TENDON_DAMPING, TENDON_SPRING_CONSTANTS };

static void tendon_spring_prepare(const void *parameters, real *k)
{
    const tendon_spring_parameters *p = parameters;
    k[TENDON_STIFFNESS] = p->stiffness, k[TENDON_DAMPING] = p->damping;
    k[TENDON_LOW] = p->rest_low, k[TENDON_HIGH] = p->rest_high;
}

static real tendon_spring_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)x, (void)u;
    const real over = l - clamped(l, k[TENDON_LOW], k[TENDON_HIGH]);
    return k[TENDON_STIFFNESS] * over + k[TENDON_DAMPING] * v;
}

TENSION_LAW(tendon_spring) = {
    .constants = TENDON_SPRING_CONSTANTS,
    .prepare = tendon_spring_prepare,
    .tension = tendon_spring_tension,
};
