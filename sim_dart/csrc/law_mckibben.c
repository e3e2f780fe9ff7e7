/* mckibben: a bladder in a braided sleeve. A thread of length b that goes n times round a cylinder of
   length L and diameter D leaves V(L) = pi D^2 L / 4 with D^2 = (b^2 - L^2) / (n pi)^2; virtual work,
   f dL = -p dV, gives

       f = p (3 L^2 - b^2) / (4 pi n^2)

   Chou & Hannaford 1996, IEEE Trans. Robotics Autom. 12. The pressure p, above that of the air, follows
   its set point u with a time constant.                                                               */
#include "elementary.h"
#include "law.h"

#include <math.h>
#include <stddef.h>

enum { MCKIBBEN_PARAMETERS(AT) PARAMETERS };
enum { THREAD2 = LAW_OWN, FOUR_PI_TURNS2, CORD, TIME_CONSTANT, CONSTANTS };

static const real PI = 3.14159265358979323846;

static const char *refusal(const real *p)
{
    if (!(value_of(p[AT_thread_length]) > 0 && value_of(p[AT_thread_length]) <= 1e3))
        return "thread_length must be positive, and 1000 at most";
    if (!(value_of(p[AT_turns]) >= 1e-3)) return "turns must be 0.001 at least";
    if (value_of(p[AT_cord_length]) < 0) return "cord_length must not be negative";
    if (!(value_of(p[AT_max_pressure]) > 0)) return "max_pressure must be positive";
    return value_of(p[AT_pressure_time_constant]) < 0 ? "pressure_time_constant must not be negative" : NULL;
}

static void prepare(const real *p, real *k)
{
    k[LAW_LOW] = 0, k[LAW_HIGH] = p[AT_max_pressure];
    k[THREAD2] = p[AT_thread_length] * p[AT_thread_length];
    k[FOUR_PI_TURNS2] = 4 * PI * p[AT_turns] * p[AT_turns];
    k[CORD] = p[AT_cord_length], k[TIME_CONSTANT] = p[AT_pressure_time_constant];
}

static int states(const real *p)
{
    (void)p;
    return 1;
}

/* A path shorter than the cord leaves a bladder of no length, not a negative one. */
static real tension(const real *k, const real *x, real l, real v, real u)
{
    (void)v, (void)u;
    const real L = larger(l - k[CORD], 0);
    return x[0] * (3 * L * L - k[THREAD2]) / k[FOUR_PI_TURNS2];
}

static void rates(const real *k, const real *x, real l, real v, real u, real *xd)
{
    (void)l, (void)v;
    xd[0] = value_of(k[TIME_CONSTANT]) > 0 ? (u - x[0]) / k[TIME_CONSTANT] : 0;
}

static void start(const real *k, real l, real u, real *x)
{
    (void)k, (void)l;
    x[0] = u;
}

static void advance(const real *k, real *x, real l, real v, real u, real h)
{
    (void)l, (void)v;
    x[0] = value_of(k[TIME_CONSTANT]) > 0 ? u + (x[0] - u) * exponential(-h / k[TIME_CONSTANT]) : u;
}

const tension_law LAW_MCKIBBEN = {
    .parameters = PARAMETERS,
    .constants = CONSTANTS,
    .driven = 1,
    .refusal = refusal,
    .prepare = prepare,
    .tension = tension,
    .states = states,
    .rates = rates,
    .start = start,
    .advance = advance,
};
