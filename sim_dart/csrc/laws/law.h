/* Muscle laws: command u, path length l, path velocity v and states x of the law -> tension f and x'.

   A law consists of one file with pure functions and an entry in the table addin_sdfusion/robot/model/laws.
   From the entry the build generates its parameter struct and its law_entry. The constants k of a law are
   computed once from its parameters; the first ones are those of enum law_constant. */
#ifndef CARDSFLOW_LAW_H
#define CARDSFLOW_LAW_H

#include "../../generated/law_parameters.h"
#include "../numbers/real_functions.h"

#include <stddef.h>

/* Minimum and maximum command; number of states; offset to the constants k of another muscle that this
   muscle shares (see shared_from): all set by laws_prepare; then the specific constants of the law. */
enum law_constant { LAW_LOW = 0, LAW_HIGH, LAW_STATES, LAW_SHARED, LAW_OWN };

/* Stretch of a cable that stretches along its path: the total stretch in [m], >= 0; its stiffness in [N/m];
   the length of cable in [m] that is not on the path, before its first point. */
typedef struct {
    real over, stiffness, lead;
} cable_stretch;

/* Numbers of a point and of a value of core_fibres and core_tendons. */
enum { FIBRE_POINT = 5, FIBRE_VALUES = 14, TENDON_NUMBERS = 2 };

/* Maximum tension in [N]: keeps a diverging state finite. */
#define MAX_TENSION 1e15

typedef struct {
    int constants;
    /* Consecutive muscles that agree in all parameters from this index on share the constants derived from
       these parameters (law_shared), which keeps them in the cache; 0 if the law has none. */
    int shared_from;
    int moves_along; /* the command is a position and moves along with the path: see core_invert */
    int is_rough; /* rounding errors are large, due to many substeps or an iteration */
    int is_hill; /* constants and states are those of hill.h */
    /* Return the error of parameters that are within their bounds, or NULL; NULL if there are no further
       rules. */
    const char *(*check)(const void *parameters);
    /* Compute the specific constants of the law; NULL if it has none. */
    void (*prepare)(const void *parameters, real *k);
    real (*tension)(const real *k, const real *x, real l, real v, real u);
    /* The next three are NULL for a law without states. */
    void (*rates)(const real *k, const real *x, real l, real v, real u, real *xd);
    void (*start)(const real *k, real l, real u, real *x);
    /* Compute x after a time h, while l grows by v h. */
    void (*advance)(const real *k, real *x, real l, real v, real u, real h);
    /* Only for a law with fibres, otherwise NULL: move a fibre from its length x[1] to the force equilibrium with
       its mean velocity during a time, at length l and activation x[0]. */
    void (*settle)(const real *k, real *x, real l, real time);
    /* Only for a cable with weight between two points, otherwise NULL: compute the constants that depend on
       its position, and the forces that pull its two points down in addition to the tension along the chord. */
    void (*place)(real *k, const real chord[3], const real gravity[3]);
    void (*weigh)(const real *k, real l, real u, real down[2]);
    /* Only for a cable that stretches along its path, otherwise NULL; u as for its tension. */
    cable_stretch (*stretch)(const real *k, const real *x, real l, real u);
    /* Return a command near the one that results in f, and a step within which the tension, which decreases
       with the command, changes smoothly; or NULL. */
    real (*guess)(const real *k, const real *x, real l, real f, real *step);
    /* See core_fibres and core_tendons; NULL for a law without fibres. */
    void (*fibre)(const real *k, const real point[FIBRE_POINT], real value[FIBRE_VALUES]);
    void (*tendon)(const real *k, const real point[TENDON_NUMBERS], real value[TENDON_NUMBERS]);
    /* See core_curve; NULL for a law without curves. */
    real (*curve)(const real *k, const char *name, real x, real *slope);
} tension_law;

/* Bounds of a parameter: finite, and from `low` to `high`; open: above `low`. */
typedef struct {
    constant low, high;
    int is_open;
    const char *words;
} law_bounds;

/* Entry of a law in the table. */
typedef struct {
    const char *name;
    const tension_law *law;
    int parameters;
    int driven; /* whether the muscle has a command */
    int pushes; /* whether its tension may be negative */
    const uint8_t *bounds;    /* row of BOUNDS for each parameter */
    const char *const *names; /* name of each parameter */
    /* Return the rule that parameters within their bounds violate, or NULL; NULL for a law without rules. */
    const char *(*broken_rule)(const void *parameters);
    /* Return the number of states; NULL for 0. */
    int (*states)(const void *parameters);
    /* Set k[LAW_LOW] and k[LAW_HIGH]. */
    void (*range)(const void *parameters, real *k);
} law_entry;

/* TENSION_LAW(kind) = {...} defines a law; the table declares it. */
#if IS_ONE_UNIT
#define TENSION_LAW(kind) static const tension_law LAW_##kind
#else
#define TENSION_LAW(kind) const tension_law LAW_##kind
#endif
/* Functions that check a robot, or are called from outside of the core. A handle with tangents or lanes is a copy of a
   plain one and does not need them. */
#if IS_ONE_UNIT
#define WHEN_OPENED(function) NULL
#else
#define WHEN_OPENED(function) function
#endif

static inline const real *law_shared(const real *k)
{
    return k + index_of(k[LAW_SHARED]);
}

static inline real clamped(real x, real low, real high)
{
    return choose(value_of(x) < value_of(low), low, choose(value_of(x) > value_of(high), high, x));
}

#if !defined(CARDSFLOW_LANES)
/* Return a number of steps, from 1 to `maximum`. NaN results in 1, since it cannot be converted to an integer. */
static inline int whole_steps(real x, int maximum)
{
    return !(value_of(x) > 1) ? 1 : value_of(x) < maximum ? (int)value_of(x) : maximum;
}
#endif

#endif
