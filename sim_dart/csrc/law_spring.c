/* passive_spring: f = K (l - l0), which pushes when it is too short, as CASPR has it. */
#include "law.h"

#include <stddef.h>

enum { SPRING_PARAMETERS(AT) PARAMETERS };
enum { STIFFNESS = LAW_OWN, REST_LENGTH, CONSTANTS };

static const char *refusal(const real *p)
{
    return value_of(p[AT_K]) < 0 ? "K must not be negative" : NULL;
}

static void prepare(const real *p, real *k)
{
    k[LAW_LOW] = k[LAW_HIGH] = 0;
    k[STIFFNESS] = p[AT_K], k[REST_LENGTH] = p[AT_l0];
}

static real tension(const real *k, const real *x, real l, real v, real u)
{
    (void)x, (void)v, (void)u;
    return k[STIFFNESS] * (l - k[REST_LENGTH]);
}

const tension_law LAW_SPRING = {
    .parameters = PARAMETERS,
    .constants = CONSTANTS,
    .pushes = 1,
    .refusal = refusal,
    .prepare = prepare,
    .tension = tension,
};
