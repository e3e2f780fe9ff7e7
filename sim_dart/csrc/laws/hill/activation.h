/* Activation of Hill-type muscles, and the indices of its parameters among the constants of a law. */
#ifndef CARDSFLOW_ACTIVATION_H
#define CARDSFLOW_ACTIVATION_H

#include "../law.h"

/* Constants that every Hill-type law has before its specific ones. */
enum {
    HILL_FORCE = LAW_OWN,  /* F0 */
    HILL_OPTIMUM,          /* optimal fibre length */
    HILL_PER_OPTIMUM,      /* its inverse */
    HILL_SLACK,            /* tendon slack length */
    HILL_HEIGHT2,          /* square of the height */
    HILL_SPEED,            /* maximum contraction velocity, in [m/s] */
    HILL_PER_SPEED,        /* its inverse */
    HILL_DAMPING,          /* beta */
    HILL_MIN_FIBRE,         /* minimum fibre length, in [m] */
    HILL_MIN_PROJECTED,          /* its projection on the tendon */
    HILL_ELASTIC,          /* whether the tendon is elastic */
    HILL_RISE,             /* inverse time constant of activation */
    HILL_FALL,             /* inverse time constant of deactivation */
    HILL_MIN_ACTIVATION, /* minimum activation */
    HILL_SMOOTHING,        /* of the transition between both; 0: a switch */
    HILL_CONSTANTS
};

/* Compute a' = (u - a) / tau(a, u); and a after a time h with constant u. */
CORE_INSIDE real activation_rate(const real *k, real a, real u);
CORE_INSIDE real activation_after(const real *k, real a, real u, real h);

/* Compute the excitation with a given activation and activation rate, with its derivatives by both. A switch
   between the time constants is replaced by a smooth transition, since with a switch the least excitations
   alternate between rising and falling activations. */
CORE_INSIDE void activation_inverse(const real *k, real a, real rate, real value[3]);

/* Activations of several muscles, one lane each: their operations overlap, or form one vector instruction. */
#define ACTIVATIONS 16
typedef struct {
    int count;
    const real *k[ACTIVATIONS];
    real *state[ACTIVATIONS];
    real a[ACTIVATIONS], u[ACTIVATIONS], rise[ACTIVATIONS], fall[ACTIVATIONS], smoothing[ACTIVATIONS];
    real decay[ACTIVATIONS], step[ACTIVATIONS];
} activations;

/* Advance *a by h, at the next `finish` at the latest. */
CORE_INSIDE void activations_add(activations *s, const real *k, real *a, real u, real h);
CORE_INSIDE void activations_finish(activations *s, real h);

static inline real hill_activation(const real *k, real a)
{
    return clamped(a, k[HILL_MIN_ACTIVATION], number(1));
}

#endif
