/* Elementary functions with bit-identical results on every platform.

   Functions of platform libraries differ in the last digit, so that trajectories would differ too. These
   functions use only additions, multiplications, divisions and square roots, for which IEEE 754 specifies
   the rounding. Errors are below one unit in the last place for the arguments that occur for robots; see
   elementary.c. */
#ifndef CARDSFLOW_ELEMENTARY_H
#define CARDSFLOW_ELEMENTARY_H

#include "../numbers/real_functions.h"

#if defined(CARDSFLOW_TANGENT)
#include "elementary_complex.h"
#elif defined(CARDSFLOW_LANES)
#include "../numbers/elementary_lanes.h"
#else

void sine_cosine(real x, real *sine, real *cosine);
real sine(real x);
real cosine(real x);
real arc_tangent(real y, real x); /* as atan2 */
real arc_sine(real x);              /* of x clamped to [-1, 1] */
real arc_cosine(real x);            /* likewise */
real exponential(real x);
void exponential_of_four(const real x[4], real y[4]); /* bit-identical to four calls, but faster */
real exponential_less_one(real x); /* as expm1 */
real logarithm(real x);
real hyperbolic_tangent(real x);

#endif

#define PI 3.14159265358979323846

/* fmax and fmin are not used: their result for 0 and -0 depends on the platform. */
static inline real larger(real a, real b)
{
    return choose(value_of(a) > value_of(b), a, b);
}
static inline real smaller(real a, real b)
{
    return choose(value_of(a) < value_of(b), a, b);
}

#endif
