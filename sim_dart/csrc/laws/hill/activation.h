/* The activation of muscles of Hill's type, and where its numbers are among such a law's constants. */
#ifndef CARDSFLOW_ACTIVATION_H
#define CARDSFLOW_ACTIVATION_H

#include "../law.h"

/* Constants that every such law has, before its own. */
enum {
    HILL_FORCE = LAW_OWN,  /* F0 */
    HILL_OPTIMUM,          /* optimal fibre length */
    HILL_PER_OPTIMUM,      /* one over it */
    HILL_SLACK,            /* tendon slack length */
    HILL_HEIGHT2,          /* square of the height */
    HILL_SPEED,            /* largest contraction velocity, in [m/s] */
    HILL_PER_SPEED,        /* one over it */
    HILL_DAMPING,          /* beta */
    HILL_SHORTEST,         /* fibre length, in [m] */
    HILL_NEAREST,          /* the same along the tendon */
    HILL_ELASTIC,          /* whether the tendon gives */
    HILL_RISE,             /* one over the time constant of activation */
    HILL_FALL,             /* and of deactivation */
    HILL_LEAST_ACTIVATION, /* minimum activation */
    HILL_SMOOTHING,        /* of the change between the two; 0: it switches */
    HILL_CONSTANTS
};

/* a' = (u - a) / tau(a, u), and a after a time h with constant u. */
CORE_INSIDE real activation_rate(const real *k, real a, real u);
CORE_INSIDE real activation_after(const real *k, real a, real u, real h);

/* The same of many muscles, a lane each: what every one waits for overlaps, or is one vector instruction. */
#define ACTIVATIONS 16
typedef struct {
    int count;
    const real *k[ACTIVATIONS];
    real *state[ACTIVATIONS];
    real a[ACTIVATIONS], u[ACTIVATIONS], rise[ACTIVATIONS], fall[ACTIVATIONS], smoothing[ACTIVATIONS];
    real decay[ACTIVATIONS], step[ACTIVATIONS];
} activations;

/* Have *a continue by h, by the next `finish` at the latest. */
CORE_INSIDE void activations_add(activations *s, const real *k, real *a, real u, real h);
CORE_INSIDE void activations_finish(activations *s, real h);

static inline real hill_activation(const real *k, real a)
{
    return clamped(a, k[HILL_LEAST_ACTIVATION], 1);
}

#endif
