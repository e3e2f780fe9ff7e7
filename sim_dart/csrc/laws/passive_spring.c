/* passive_spring: f = K (l - l0), which pushes when it is compressed, as in CASPR. */
#include "law.h"

enum { SPRING_STIFFNESS = LAW_OWN, SPRING_REST_LENGTH, SPRING_CONSTANTS };

static void spring_prepare(const void *parameters, real *k)
{
    const passive_spring_parameters *p = parameters;
    k[SPRING_STIFFNESS] = p->K, k[SPRING_REST_LENGTH] = p->l0;
}

static real spring_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)x, (void)v, (void)u;
    return k[SPRING_STIFFNESS] * (l - k[SPRING_REST_LENGTH]);
}

TENSION_LAW(passive_spring) = {
    .constants = SPRING_CONSTANTS,
    .prepare = spring_prepare,
    .tension = spring_tension,
};
