/* Cables and springs: laws without states. */
#include "../math/elementary.h"
#include "law.h"

#include <math.h>
#include <stddef.h>

/* ideal: f = max(u, 0) */

enum { IDEAL_CONSTANTS = LAW_OWN };

static void ideal_prepare(const void *parameters, real *k)
{
    (void)parameters;
    k[LAW_LOW] = 0, k[LAW_HIGH] = INFINITY;
}

static real ideal_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)k, (void)x, (void)l, (void)v;
    return u;
}

TENSION_LAW(IDEAL) = {
    .constants = IDEAL_CONSTANTS,
    .driven = 1,
    .prepare = WHEN_OPENED(ideal_prepare),
    .tension = ideal_tension,
};

/* elastic_cable: f = k (l - u) + d l' while it is taut; u is its length without force. */

typedef struct {
    ELASTIC_CABLE_PARAMETERS(PARAMETER)
} cable_parameters;

enum { CABLE_STIFFNESS = LAW_OWN, CABLE_DAMPING, CABLE_CONSTANTS };

static const char *cable_refusal(const void *parameters)
{
    const cable_parameters *p = parameters;
    if (!(value_of(p->stiffness) > 0)) return "stiffness must be positive";
    if (value_of(p->damping) < 0) return "damping must not be negative";
    return value_of(p->longest_rest_length) > 0 ? NULL : "longest_rest_length must be positive";
}

static void cable_prepare(const void *parameters, real *k)
{
    const cable_parameters *p = parameters;
    k[LAW_LOW] = 0, k[LAW_HIGH] = p->longest_rest_length;
    k[CABLE_STIFFNESS] = p->stiffness, k[CABLE_DAMPING] = p->damping;
}

static real cable_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)x;
    return value_of(l) > value_of(u) ? k[CABLE_STIFFNESS] * (l - u) + k[CABLE_DAMPING] * v : 0;
}

static cable_stretch cable_stretched(const real *k, const real *x, real l, real u)
{
    (void)x;
    return (cable_stretch){larger(l - u, 0), k[CABLE_STIFFNESS], 0};
}

TENSION_LAW(ELASTIC_CABLE) = {
    .parameters = PARAMETER_COUNT(cable_parameters),
    .constants = CABLE_CONSTANTS,
    .driven = 1,
    .refusal = WHEN_OPENED(cable_refusal),
    .prepare = WHEN_OPENED(cable_prepare),
    .tension = cable_tension,
    .stretch = cable_stretched,
};
