/* Common part of Hill-type muscles: a fibre at a pennation angle to its tendon, and activation.

     F0 (a fL(z) fV(w) + fPE(z) + beta w) cos(alpha) = F0 fT(lT)

   with z the fibre length over its optimum, w the fibre velocity over the maximum contraction velocity,
   positive while lengthening, and lT the tendon length over its slack length. The thickness of the fibre is
   constant: (fibre length) sin(alpha) = height. */
#ifndef CARDSFLOW_HILL_H
#define CARDSFLOW_HILL_H

#include "activation.h"

#include <math.h>

/* Beyond this normalised length or velocity, curves are constant to avoid overflow. */
#define HILL_MAX_NORMALISED 1e6

/* Return y(x) and, unless `slope` is NULL, dy/dx. */
typedef real hill_curve(const real *k, real x, real *slope);

typedef struct {
    hill_curve *active, *velocity, *passive, *tendon;
    /* Factor of the maximum contraction velocity, by activation; NULL for 1. */
    real (*speed)(real a);
    /* fL(z) fV(w) and fPE(z) in one call, if this is faster; otherwise NULL. */
    real (*product)(const real *k, real z, real w, real *passive);
} hill_curves;

/* Time of the first stage of hill_advance as a fraction of the step. */
static const real HILL_STAGE = 0.2928932188134524756; /* 1 - 1 / sqrt(2) */

/* Compute the constants. Fibres stay longer than `shortest` optimal lengths, and their angle stays below
   `steepest`. */
CORE_INSIDE void hill_prepare(const void *parameters, real shortest, real steepest, real damping,
                              real smoothing, real *k);
CORE_INSIDE real hill_elastic_tension(const hill_curves *f, const real *k, const real *x, real l);
CORE_INSIDE void hill_rates(const hill_curves *f, const real *k, const real *x, real l, real v, real u,
                            real *xd);
CORE_INSIDE void hill_start(const hill_curves *f, const real *k, real l, real u, real *x);
/* See law.h. Such an equilibrium exists also for a muscle without activation and damping. */
CORE_INSIDE void hill_settle(const hill_curves *f, const real *k, real *x, real l, real time);
CORE_INSIDE void hill_advance(const hill_curves *f, const real *k, real *x, real l, real v, real u, real h);
/* Advance the fibre, with its activation x[0] at the end of the step and `early` after HILL_STAGE h. */
CORE_INSIDE void hill_advance_fibre(const hill_curves *f, const real *k, real *x, real early, real l, real v,
                                    real h);
CORE_INSIDE void hill_tendon(const hill_curves *f, const real *k, const real *point, real *value);
CORE_INSIDE void hill_fibre(const hill_curves *f, const real *k, const real *point, real *value);
CORE_INSIDE real hill_curve_by_name(const hill_curves *f, const real *k, const char *name, real x, real *slope);

/* Return fL(z) fV(w) and compute fPE(z). */
static inline real hill_product(const hill_curves *f, const real *k, real z, real w, real *passive)
{
    if (f->product) return f->product(k, z, w, passive);
    *passive = f->passive(k, z, NULL);
    return f->active(k, z, NULL) * f->velocity(k, w, NULL);
}

/* This function is in the header so that it is compiled together with the curves: most muscles call it in
   each step. */
static inline real hill_rigid_tension(const hill_curves *f, const real *k, real a, real l,
                                      real v)
{
    const real along = l - k[HILL_SLACK];
    if (value_of(along) <= 0 || value_of(along) < value_of(k[HILL_MIN_PROJECTED])) return 0; /* the tendon is slack */
    const real fibre = sqrt(along * along + k[HILL_HEIGHT2]), cosine = along / fibre;
    const real z = clamped(fibre * k[HILL_PER_OPTIMUM], 0, HILL_MAX_NORMALISED);
    const real w = v * cosine * k[HILL_PER_SPEED], speed = f->speed ? f->speed(a) : 1;
    const real scaled = clamped(w / speed, -HILL_MAX_NORMALISED, HILL_MAX_NORMALISED);
    real passive;
    const real active = a * hill_product(f, k, z, scaled, &passive);
    return k[HILL_FORCE] * (active + passive + k[HILL_DAMPING] * w) * cosine;
}

/* Define the functions of `law` that depend on its curves, `law`_curves. */
#define HILL_FUNCTIONS(law)                                                                            \
    static real law##_tension(const real *k, const real *x, real l, real v, real u)                    \
    {                                                                                                  \
        (void)u;                                                                                       \
        if (k[HILL_ELASTIC]) return hill_elastic_tension(&law##_curves, k, x, l);                      \
        return hill_rigid_tension(&law##_curves, k, hill_activation(k, x[0]), l, v);                   \
    }                                                                                                  \
    static void law##_rates(const real *k, const real *x, real l, real v, real u, real *xd)            \
    {                                                                                                  \
        hill_rates(&law##_curves, k, x, l, v, u, xd);                                                  \
    }                                                                                                  \
    static void law##_start(const real *k, real l, real u, real *x)                                    \
    {                                                                                                  \
        hill_start(&law##_curves, k, l, u, x);                                                         \
    }                                                                                                  \
    static void law##_settle(const real *k, real *x, real l, real time)                                \
    {                                                                                                  \
        hill_settle(&law##_curves, k, x, l, time);                                                     \
    }                                                                                                  \
    static void law##_advance(const real *k, real *x, real l, real v, real u, real h)                  \
    {                                                                                                  \
        hill_advance(&law##_curves, k, x, l, v, u, h);                                                 \
    }                                                                                                  \
    static void law##_tendon_length(const real *k, const real *point, real *value)                     \
    {                                                                                                  \
        hill_tendon(&law##_curves, k, point, value);                                                   \
    }                                                                                                  \
    static void law##_fibre(const real *k, const real *point, real *value)                             \
    {                                                                                                  \
        hill_fibre(&law##_curves, k, point, value);                                                    \
    }                                                                                                  \
    static real law##_curve(const real *k, const char *name, real x, real *slope)                      \
    {                                                                                                  \
        return hill_curve_by_name(&law##_curves, k, name, x, slope);                                   \
    }

#define HILL_LAW(law, constant_count)                                                                  \
    .constants = constant_count, .prepare = law##_prepare, .tension = law##_tension,      \
    .rates = law##_rates, .start = law##_start, .advance = law##_advance, .settle = law##_settle,      \
    .fibre = WHEN_OPENED(law##_fibre), .tendon = WHEN_OPENED(law##_tendon_length), \
    .curve = WHEN_OPENED(law##_curve), .is_hill = 1

#endif
