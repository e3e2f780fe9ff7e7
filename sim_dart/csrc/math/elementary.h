/* Elementary functions that give the same bits on every platform.

   Those of the platforms' own libraries differ in the last digit, so trajectories would differ too. These
   use additions, multiplications, divisions and square roots only, which IEEE 754 rounds in one way.
   Errors stay below one unit in the last place for arguments that robots have; see elementary.c.       */
#ifndef CARDSFLOW_ELEMENTARY_H
#define CARDSFLOW_ELEMENTARY_H

#include "../numbers/real_functions.h"

#if defined(CARDSFLOW_TANGENT)
#include "elementary_complex.h"
#else

void sine_cosine(real x, real *sine, real *cosine);
real sine(real x);
real cosine(real x);
real arc_tangent(real y, real x); /* as atan2 */
real arc_sine(real x);              /* of x clamped to [-1, 1] */
real arc_cosine(real x);            /* likewise */
real exponential(real x);
void exponential_of_four(const real x[4], real y[4]); /* the same bits, sooner */
real exponential_less_one(real x); /* as expm1 */
real logarithm(real x);
real hyperbolic_tangent(real x);

#endif

#define PI 3.14159265358979323846

/* Not fmax and fmin: whether these give 0 or -0 of the two is left to the platform. */
static inline real larger(real a, real b)
{
    return value_of(a) > value_of(b) ? a : b;
}
static inline real smaller(real a, real b)
{
    return value_of(a) < value_of(b) ? a : b;
}

#endif
