/* Elementary functions that give the same bits on every platform.

   Those of the platforms' own libraries differ in the last digit, so trajectories would differ too. These
   use additions, multiplications, divisions and square roots only, which IEEE 754 rounds in one way.
   Errors stay below one unit in the last place for arguments that robots have; see elementary.c.       */
#ifndef CARDSFLOW_ELEMENTARY_H
#define CARDSFLOW_ELEMENTARY_H

void sine_cosine(double x, double *sine, double *cosine);
double sine(double x);
double cosine(double x);
double arc_tangent(double y, double x); /* as atan2 */
double arc_sine(double x);              /* of x clamped to [-1, 1] */
double arc_cosine(double x);            /* likewise */
double exponential(double x);
void exponential_of_four(const double x[4], double y[4]); /* the same bits, sooner */
double exponential_less_one(double x); /* as expm1 */
double logarithm(double x);
double hyperbolic_tangent(double x);

/* Not fmax and fmin: whether these give 0 or -0 of the two is left to the platform. */
static inline double larger(double a, double b)
{
    return a > b ? a : b;
}
static inline double smaller(double a, double b)
{
    return a < b ? a : b;
}

#endif
