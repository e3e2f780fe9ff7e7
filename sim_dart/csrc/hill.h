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
typedef double hill_curve(const double *k, double x, double *slope);

typedef struct {
    hill_curve *active, *velocity, *passive, *tendon;
    /* By activation, what the largest contraction velocity is multiplied with; NULL for 1. */
    double (*speed)(double a);
    /* The active and the passive curve at once, where that is quicker; NULL where it is not. */
    double (*lengths)(const double *k, double x, double *passive);
} hill_curves;

/* Fibres stay longer than `shortest` optimal lengths, and their angle below `steepest`. */
void hill_prepare(const double *p, double shortest, double steepest, double damping, double smoothing,
                  double *k);
const char *hill_refusal(const double *p);
int hill_states(const double *p);
double hill_elastic_tension(const hill_curves *f, const double *k, const double *x, double l);
void hill_rates(const hill_curves *f, const double *k, const double *x, double l, double v, double u,
                double *xd);
void hill_start(const hill_curves *f, const double *k, double l, double u, double *x);
void hill_advance(const hill_curves *f, const double *k, double *x, double l, double v, double u,
                  double h);
double hill_curve_by_name(const hill_curves *f, const double *k, const char *name, double x,
                          double *slope);

/* a' = (u - a) / tau(a, u), and a after a time h with constant u. */
double activation_rate(const double *k, double a, double u);
double activation_after(const double *k, double a, double u, double h);

static inline double hill_activation(const double *k, double a)
{
    return clamped(a, k[HILL_LEAST_ACTIVATION], 1);
}

static inline double hill_lengths(const hill_curves *f, const double *k, double z, double *passive)
{
    if (f->lengths) return f->lengths(k, z, passive);
    *passive = f->passive(k, z, NULL);
    return f->active(k, z, NULL);
}

/* Here, so that it is compiled together with the curves: it is what most muscles ask for in each step. */
static inline double hill_rigid_tension(const hill_curves *f, const double *k, double a, double l,
                                        double v)
{
    const double along = l - k[HILL_SLACK];
    if (along <= 0 || along < k[HILL_NEAREST]) return 0; /* the tendon is slack */
    const double fibre = sqrt(along * along + k[HILL_HEIGHT2]), cosine = along / fibre;
    const double z = clamped(fibre * k[HILL_PER_OPTIMUM], 0, HILL_FARTHEST);
    const double w = v * cosine * k[HILL_PER_SPEED], speed = f->speed ? f->speed(a) : 1;
    const double velocity = f->velocity(k, clamped(w / speed, -HILL_FARTHEST, HILL_FARTHEST), NULL);
    double passive;
    const double active = a * hill_lengths(f, k, z, &passive) * velocity;
    return k[HILL_FORCE] * (active + passive + k[HILL_DAMPING] * w) * cosine;
}

/* The tension_law functions of a law with the curves CURVES. */
#define HILL_FUNCTIONS(CURVES)                                                                         \
    static double tension(const double *k, const double *x, double l, double v, double u)              \
    {                                                                                                  \
        (void)u;                                                                                       \
        if (k[HILL_ELASTIC]) return hill_elastic_tension(&CURVES, k, x, l);                            \
        return hill_rigid_tension(&CURVES, k, hill_activation(k, x[0]), l, v);                         \
    }                                                                                                  \
    static void rates(const double *k, const double *x, double l, double v, double u, double *xd)      \
    {                                                                                                  \
        hill_rates(&CURVES, k, x, l, v, u, xd);                                                        \
    }                                                                                                  \
    static void start(const double *k, double l, double u, double *x)                                  \
    {                                                                                                  \
        hill_start(&CURVES, k, l, u, x);                                                               \
    }                                                                                                  \
    static void advance(const double *k, double *x, double l, double v, double u, double h)            \
    {                                                                                                  \
        hill_advance(&CURVES, k, x, l, v, u, h);                                                       \
    }                                                                                                  \
    static double curve(const double *k, const char *name, double x, double *slope)                    \
    {                                                                                                  \
        return hill_curve_by_name(&CURVES, k, name, x, slope);                                         \
    }

#define HILL_LAW(parameter_count, constant_count)                                                      \
    {                                                                                                  \
        .parameters = parameter_count, .constants = constant_count, .driven = 1, .refusal = refusal,   \
        .prepare = prepare, .tension = tension, .states = hill_states, .rates = rates, .start = start, \
        .advance = advance, .curve = curve                                                             \
    }

#endif
