/* Springs along a path. */
#include "../math/elementary.h"
#include "law.h"

#include <stddef.h>

/* passive_spring: f = K (l - l0), which pushes when it is too short, as CASPR has it. */

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
    .refusal = WHEN_OPENED(spring_refusal),
    .prepare = WHEN_OPENED(spring_prepare),
    .tension = spring_tension,
};

/* path_spring: f = K (l - l0) (1 + D l') while it is stretched, and never below 0, as OpenSim's PathSpring. */

typedef struct {
    PATH_SPRING_PARAMETERS(PARAMETER)
} path_spring_parameters;

enum { PATH_STIFFNESS = LAW_OWN, PATH_REST_LENGTH, PATH_DISSIPATION, PATH_SPRING_CONSTANTS };

static const char *path_spring_refusal(const void *parameters)
{
    const path_spring_parameters *p = parameters;
    if (value_of(p->rest_length) < 0) return "rest_length must not be negative";
    return value_of(p->stiffness) < 0 || value_of(p->dissipation) < 0
               ? "stiffness and dissipation must not be negative"
               : NULL;
}

static void path_spring_prepare(const void *parameters, real *k)
{
    const path_spring_parameters *p = parameters;
    k[LAW_LOW] = k[LAW_HIGH] = 0;
    k[PATH_STIFFNESS] = p->stiffness, k[PATH_REST_LENGTH] = p->rest_length, k[PATH_DISSIPATION] = p->dissipation;
}

static real path_spring_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)x, (void)u;
    const real stretch = larger(l - k[PATH_REST_LENGTH], 0);
    return k[PATH_STIFFNESS] * stretch * (1 + k[PATH_DISSIPATION] * v);
}

static cable_stretch path_spring_stretched(const real *k, const real *x, real l, real u)
{
    (void)x, (void)u;
    return (cable_stretch){larger(l - k[PATH_REST_LENGTH], 0), k[PATH_STIFFNESS], 0};
}

TENSION_LAW(PATH_SPRING) = {
    .parameters = PARAMETER_COUNT(path_spring_parameters),
    .constants = PATH_SPRING_CONSTANTS,
    .refusal = WHEN_OPENED(path_spring_refusal),
    .prepare = WHEN_OPENED(path_spring_prepare),
    .tension = path_spring_tension,
    .stretch = path_spring_stretched,
};

/* tendon_spring: f = k (l - l_high) above l_high, k (l - l_low) below l_low, nothing between, and d l' in any
   case, as a tendon in MuJoCo: it pushes when it is too short.                                         */

typedef struct {
    TENDON_SPRING_PARAMETERS(PARAMETER)
} tendon_spring_parameters;

enum { TENDON_STIFFNESS = LAW_OWN, TENDON_LOW, TENDON_HIGH, TENDON_DAMPING, TENDON_SPRING_CONSTANTS };

static const char *tendon_spring_refusal(const void *parameters)
{
    const tendon_spring_parameters *p = parameters;
    if (value_of(p->rest_low) > value_of(p->rest_high) || value_of(p->rest_low) < 0)
        return "rest_low must not be negative, nor above rest_high";
    return value_of(p->stiffness) < 0 || value_of(p->damping) < 0
               ? "stiffness and damping must not be negative"
               : NULL;
}

static void tendon_spring_prepare(const void *parameters, real *k)
{
    const tendon_spring_parameters *p = parameters;
    k[LAW_LOW] = k[LAW_HIGH] = 0;
    k[TENDON_STIFFNESS] = p->stiffness, k[TENDON_DAMPING] = p->damping;
    k[TENDON_LOW] = p->rest_low, k[TENDON_HIGH] = p->rest_high;
}

static real tendon_spring_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)x, (void)u;
    const real over = l - clamped(l, k[TENDON_LOW], k[TENDON_HIGH]);
    return k[TENDON_STIFFNESS] * over + k[TENDON_DAMPING] * v;
}

TENSION_LAW(TENDON_SPRING) = {
    .parameters = PARAMETER_COUNT(tendon_spring_parameters),
    .constants = TENDON_SPRING_CONSTANTS,
    .pushes = 1,
    .refusal = WHEN_OPENED(tendon_spring_refusal),
    .prepare = WHEN_OPENED(tendon_spring_prepare),
    .tension = tendon_spring_tension,
};
