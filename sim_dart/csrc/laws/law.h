/* Muscle laws: command u, path length l, its rate v and the law's own states x -> tension f and x'.

   A law is one file with pure functions, and an entry in the table addin_sdfusion/robot/model/laws, of which
   the build makes its struct of parameters and its law_entry. What it makes of its parameters once are its
   constants k, which begin in every law as enum law_constant says.                                    */
#ifndef CARDSFLOW_LAW_H
#define CARDSFLOW_LAW_H

#include "../../generated/law_parameters.h"
#include "../numbers/real_functions.h"

#include <stddef.h>

/* Smallest and largest command; how many states there are, and how far off the constants k are that this
   muscle shares with others (see shared_from): all set by laws_prepare; the law's own.                  */
enum law_constant { LAW_LOW = 0, LAW_HIGH, LAW_STATES, LAW_SHARED, LAW_OWN };

/* How a cable is stretched that stretches all along its path: by how much in all, in [m], from 0 on; newtons a metre of
   that; and how much of it lies beside the path, in front of its first point, in [m].                     */
typedef struct {
    real over, stiffness, lead;
} cable_stretch;

/* Nothing real pulls harder, in [N]: keeps a state that runs away a number. */
#define MAX_TENSION 1e15

typedef struct {
    int constants;
    /* Muscles in a row that agree in all parameters from this one on look at one of them for what it makes
       of these (law_shared), which so stays at hand; 0 if there is nothing of the kind.                 */
    int shared_from;
    int moves_along; /* its command is a position, which moves along with the path: see core_invert */
    int is_rough; /* its tension is rounded by more than a few sums: of many substeps, or at a root */
    int is_hill; /* its constants and states are those of hill.h */
    /* What is wrong with parameters that are as the table asks, or NULL; NULL if nothing can be. */
    const char *(*refusal)(const void *parameters);
    /* Sets the law's own constants; NULL for one without. */
    void (*prepare)(const void *parameters, real *k);
    real (*tension)(const real *k, const real *x, real l, real v, real u);
    /* The next three are NULL for a law without states. */
    void (*rates)(const real *k, const real *x, real l, real v, real u, real *xd);
    void (*start)(const real *k, real l, real u, real *x);
    /* x after a time h, while l grows by v h. */
    void (*advance)(const real *k, real *x, real l, real v, real u, real h);
    /* NULL but for a cable with weight, between two points: the constants that follow from where it is; what
       pulls its two points down next to its tension, which is that along the chord.                     */
    void (*place)(real *k, const real chord[3], const real gravity[3]);
    void (*weigh)(const real *k, real l, real u, real down[2]);
    /* NULL but for what stretches all along its path; u as for its tension. */
    cable_stretch (*stretch)(const real *k, const real *x, real l, real u);
    /* A command near that which gives f, and a step from there within which the tension, which falls with
       the command, changes smoothly; or NULL.                                                          */
    real (*guess)(const real *k, const real *x, real l, real f, real *step);
    /* See core_curve; NULL for a law without curves. */
    real (*curve)(const real *k, const char *name, real x, real *slope);
} tension_law;

/* What a parameter has to be: finite, and from `low` to `high`; open: above `low`. */
typedef struct {
    real low, high;
    int is_open;
    const char *words;
} law_bounds;

/* A law in the table. */
typedef struct {
    const char *name;
    const tension_law *law;
    int parameters;
    int driven; /* has a command */
    int pushes; /* its tension may be negative */
    const uint8_t *bounds;    /* row of BOUNDS of each parameter */
    const char *const *names; /* name of each parameter */
    /* What rule parameters within their bounds break, or NULL; NULL for a law without rules. */
    const char *(*broken_rule)(const void *parameters);
    /* How many states it has; NULL for none. */
    int (*states)(const void *parameters);
    /* Sets k[LAW_LOW] and k[LAW_HIGH]. */
    void (*range)(const void *parameters, real *k);
} law_entry;

/* TENSION_LAW(kind) = {...} defines a law; the table declares it. */
#if defined(CARDSFLOW_TANGENT)
#define TENSION_LAW(kind) static const tension_law LAW_##kind
#else
#define TENSION_LAW(kind) const tension_law LAW_##kind
#endif
/* What is called when a robot is opened, or from outside: a handle with tangents is a copy of a plain one. */
#if defined(CARDSFLOW_TANGENT)
#define WHEN_OPENED(function) NULL
#else
#define WHEN_OPENED(function) function
#endif

static inline const real *law_shared(const real *k)
{
    return k + (ptrdiff_t)value_of(k[LAW_SHARED]);
}

static inline real clamped(real x, real low, real high)
{
    return value_of(x) < value_of(low) ? low : value_of(x) > value_of(high) ? high : x;
}

/* A number of steps, from 1 to the most; what is not a number is 1, as no integer may be made of it. */
static inline int whole_steps(real x, int most)
{
    return !(value_of(x) > 1) ? 1 : value_of(x) < most ? (int)value_of(x) : most;
}

#endif
