/* passive_spring: f = K (l - l0), which pushes when it is too short, as CASPR has it. */
#include "law.h"

#include <stddef.h>

typedef struct {
    SPRING_PARAMETERS(PARAMETER)
} spring_parameters;

enum { SPRING_STIFFNESS = LAW_OWN, SPRING_REST_LENGTH, SPRING_CONSTANTS };

static const char *spring_refusal(const void *parameters)
{
    const spring_parameters *p = parameters;
    return value_of(p->K) < 0 ? "K must not be negative" : NULL;
}

static void spring_prepare(const void *parameters, real *k)
{
    const spring_parameters *p = parameters;
    k[LAW_LOW] = k[LAW_HIGH] = 0;
    k[SPRING_STIFFNESS] = p->K, k[SPRING_REST_LENGTH] = p->l0;
}

static real spring_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)x, (void)v, (void)u;
    return k[SPRING_STIFFNESS] * (l - k[SPRING_REST_LENGTH]);
}

TENSION_LAW(SPRING) = {
    .parameters = PARAMETER_COUNT(spring_parameters),
    .constants = SPRING_CONSTANTS,
    .pushes = 1,
    .refusal = spring_refusal,
    .prepare = spring_prepare,
    .tension = spring_tension,
};
