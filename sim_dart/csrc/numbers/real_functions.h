/* The functions of <math.h> for reals, and choices between reals. They are separate from real.h, which callers
   of core and laws include: the numbers of these callers may be doubles. */
#ifndef CARDSFLOW_REAL_FUNCTIONS_H
#define CARDSFLOW_REAL_FUNCTIONS_H

#include "real.h"

#if defined(CARDSFLOW_FLOAT)
#undef fabs
#undef sqrt
#define fabs(x) fabsf(x)
#define sqrt(x) sqrtf(x)
#define fmod(x, y) fmodf(x, y)
#define ceil(x) ceilf(x)
#define round(x) roundf(x)
#endif

/* The functions below are those of lanes.h for a single number. The core compares and chooses with them where
   it also computes several instances at once. */
#if !defined(CARDSFLOW_LANES)

typedef real constant; /* a number that all lanes share */
typedef int truth;     /* result of a comparison */
typedef int whole;

static inline real number(real x)
{
    return x;
}

/* Return whether a condition holds in all lanes, or in any. */
static inline int all_of(truth x)
{
    return x;
}

static inline int any_of(truth x)
{
    return x;
}

static inline real choose(truth is, real yes, real no)
{
    return is ? yes : no;
}

#if !HAS_TANGENT
static inline whole whole_of(real x)
{
    return (int32_t)x;
}

static inline real without_fraction(real x)
{
    return (real)(int32_t)x;
}
#endif

#endif

/* Return a number that is an integer and the same in all lanes, such as an index. */
static inline int32_t index_of(real x)
{
#if defined(CARDSFLOW_LANES)
    return (int32_t)x[0];
#else
    return (int32_t)value_of(x);
#endif
}

#endif
