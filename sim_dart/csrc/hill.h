/* What muscles of Hill's type share: a fibre at an angle to its tendon, and activation.

       F0 (a fL(z) fV(w) + fPE(z) + beta w) cos(alpha) = F0 fT(lT)

   with z the fibre length over its optimum, w the fibre's velocity over the largest contraction velocity,
   positive while lengthening, lT the tendon length over its slack length. The fibre's thickness is
   constant: (fibre length) sin(alpha) = height.                                                       */
#ifndef CARDSFLOW_HILL_H
#define CARDSFLOW_HILL_H

#include "law.h"

#include <math.h>

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

/* Beyond this normalised length or velocity curves go on as constants: nothing overflows. */
#define HILL_FARTHEST 1e6

/* y(x) and, unless `slope` is NULL, dy/dx. */
typedef real hill_curve(const real *k, real x, real *slope);

typedef struct {
    hill_curve *active, *velocity, *passive, *tendon;
    /* By activation, what the largest contraction velocity is multiplied with; NULL for 1. */
    real (*speed)(real a);
    /* fL(z) fV(w), and fPE(z), at once, where that is quicker; NULL where it is not. */
    real (*product)(const real *k, real z, real w, real *passive);
} hill_curves;

/* Fibres stay longer than `shortest` optimal lengths, and their angle below `steepest`. */
void hill_prepare(const real *p, real shortest, real steepest, real damping, real smoothing,
                  real *k);
const char *hill_refusal(const real *p);
int hill_states(const real *p);
real hill_elastic_tension(const hill_curves *f, const real *k, const real *x, real l);
void hill_rates(const hill_curves *f, const real *k, const real *x, real l, real v, real u,
                real *xd);
void hill_start(const hill_curves *f, const real *k, real l, real u, real *x);
void hill_advance(const hill_curves *f, const real *k, real *x, real l, real v, real u,
                  real h);
real hill_curve_by_name(const hill_curves *f, const real *k, const char *name, real x,
                        real *slope);

/* a' = (u - a) / tau(a, u), and a after a time h with constant u. */
real activation_rate(const real *k, real a, real u);
real activation_after(const real *k, real a, real u, real h);

/* The same of many muscles, a lane each: what every one waits for overlaps, or is one vector instruction. */
#define ACTIVATIONS 16
typedef struct {
    int count;
    const real *k[ACTIVATIONS];
    real *state[ACTIVATIONS];
    real a[ACTIVATIONS], u[ACTIVATIONS], rise[ACTIVATIONS], fall[ACTIVATIONS], smoothing[ACTIVATIONS];
    real decay[ACTIVATIONS], step[ACTIVATIONS];
} activations;

/* Have *a go on by h, by the next `finish` at the latest. */
void activations_add(activations *s, const real *k, real *a, real u, real h);
void activations_finish(activations *s, real h);

static inline real hill_activation(const real *k, real a)
{
    return clamped(a, k[HILL_LEAST_ACTIVATION], 1);
}

/* fL(z) fV(w), and fPE(z) */
static inline real hill_product(const hill_curves *f, const real *k, real z, real w, real *passive)
{
    if (f->product) return f->product(k, z, w, passive);
    *passive = f->passive(k, z, NULL);
    return f->active(k, z, NULL) * f->velocity(k, w, NULL);
}

/* Here, so that it is compiled together with the curves: it is what most muscles ask for in each step. */
static inline real hill_rigid_tension(const hill_curves *f, const real *k, real a, real l,
                                      real v)
{
    const real along = l - k[HILL_SLACK];
    if (value_of(along) <= 0 || value_of(along) < value_of(k[HILL_NEAREST])) return 0; /* the tendon is slack */
    const real fibre = sqrt(along * along + k[HILL_HEIGHT2]), cosine = along / fibre;
    const real z = clamped(fibre * k[HILL_PER_OPTIMUM], 0, HILL_FARTHEST);
    const real w = v * cosine * k[HILL_PER_SPEED], speed = f->speed ? f->speed(a) : 1;
    const real scaled = clamped(w / speed, -HILL_FARTHEST, HILL_FARTHEST);
    real passive;
    const real active = a * hill_product(f, k, z, scaled, &passive);
    return k[HILL_FORCE] * (active + passive + k[HILL_DAMPING] * w) * cosine;
}

/* The tension_law functions of a law with the curves CURVES. */
#define HILL_FUNCTIONS(CURVES)                                                                         \
    static real tension(const real *k, const real *x, real l, real v, real u)                          \
    {                                                                                                  \
        (void)u;                                                                                       \
        if (k[HILL_ELASTIC]) return hill_elastic_tension(&CURVES, k, x, l);                            \
        return hill_rigid_tension(&CURVES, k, hill_activation(k, x[0]), l, v);                         \
    }                                                                                                  \
    static void rates(const real *k, const real *x, real l, real v, real u, real *xd)                  \
    {                                                                                                  \
        hill_rates(&CURVES, k, x, l, v, u, xd);                                                        \
    }                                                                                                  \
    static void start(const real *k, real l, real u, real *x)                                          \
    {                                                                                                  \
        hill_start(&CURVES, k, l, u, x);                                                               \
    }                                                                                                  \
    static void advance(const real *k, real *x, real l, real v, real u, real h)                        \
    {                                                                                                  \
        hill_advance(&CURVES, k, x, l, v, u, h);                                                       \
    }                                                                                                  \
    static real curve(const real *k, const char *name, real x, real *slope)                            \
    {                                                                                                  \
        return hill_curve_by_name(&CURVES, k, name, x, slope);                                         \
    }

#define HILL_LAW(parameter_count, constant_count, shared)                                              \
    {                                                                                                  \
        .parameters = parameter_count, .constants = constant_count, .driven = 1, .refusal = refusal,   \
        .prepare = prepare, .tension = tension, .states = hill_states, .rates = rates, .start = start, \
        .advance = advance, .curve = curve, .is_hill = 1, .shared_from = shared                        \
    }

#endif
