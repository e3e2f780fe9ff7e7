/* elastic_cable: f = k (l - u) + d l' while the cable is taut; u is the unstretched length. */
#include "../math/elementary.h"
#include "law.h"

enum { CABLE_STIFFNESS = LAW_OWN, CABLE_DAMPING, CABLE_CONSTANTS };

static void cable_prepare(const void *parameters, real *k)
{
    const elastic_cable_parameters *p = parameters;
    k[CABLE_STIFFNESS] = p->stiffness, k[CABLE_DAMPING] = p->damping;
}

static real cable_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)x;
    return choose(value_of(l) > value_of(u), k[CABLE_STIFFNESS] * (l - u) + k[CABLE_DAMPING] * v, number(0));
}

static cable_stretch cable_stretched(const real *k, const real *x, real l, real u)
{
    (void)x;
    return (cable_stretch){larger(l - u, number(0)), k[CABLE_STIFFNESS], number(0)};
}

TENSION_LAW(elastic_cable) = {
    .constants = CABLE_CONSTANTS,
    .prepare = cable_prepare,
    .tension = cable_tension,
    .stretch = cable_stretched,
};
