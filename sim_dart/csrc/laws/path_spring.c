/* path_spring: f = K (l - l0) (1 + D l') while it is stretched, and never below 0, as PathSpring in OpenSim. */
#include "../math/elementary.h"
#include "law.h"

enum { PATH_STIFFNESS = LAW_OWN, PATH_REST_LENGTH, PATH_DISSIPATION, PATH_SPRING_CONSTANTS };

static void path_spring_prepare(const void *parameters, real *k)
{
    const path_spring_parameters *p = parameters;
    k[PATH_STIFFNESS] = p->stiffness, k[PATH_REST_LENGTH] = p->rest_length, k[PATH_DISSIPATION] = p->dissipation;
}

static real path_spring_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)x, (void)u;
    const real stretch = larger(l - k[PATH_REST_LENGTH], number(0));
    return k[PATH_STIFFNESS] * stretch * (1 + k[PATH_DISSIPATION] * v);
}

static cable_stretch path_spring_stretched(const real *k, const real *x, real l, real u)
{
    (void)x, (void)u;
    return (cable_stretch){larger(l - k[PATH_REST_LENGTH], number(0)), k[PATH_STIFFNESS], number(0)};
}

TENSION_LAW(path_spring) = {
    .constants = PATH_SPRING_CONSTANTS,
    .prepare = path_spring_prepare,
    .tension = path_spring_tension,
    .stretch = path_spring_stretched,
};
