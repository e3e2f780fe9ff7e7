/* mckibben: a bladder in a braided sleeve. A thread of length b is wound n times around a cylinder of length
   L and diameter D. The volume is V(L) = pi D^2 L / 4 with D^2 = (b^2 - L^2) / (n pi)^2. Virtual work, f dL
   = -p dV, results in

     f = p (3 L^2 - b^2) / (4 pi n^2)

   Chou & Hannaford 1996, IEEE Trans. Robotics Autom. 12. The gauge pressure p follows its set point u with a
   time constant. */
#include "../math/elementary.h"
#include "law.h"

enum {
    MCKIBBEN_THREAD2 = LAW_OWN,
    MCKIBBEN_FOUR_PI_TURNS2,
    MCKIBBEN_CORD,
    MCKIBBEN_TIME_CONSTANT,
    MCKIBBEN_CONSTANTS
};

static void mckibben_prepare(const void *parameters, real *k)
{
    const mckibben_parameters *p = parameters;
    k[MCKIBBEN_THREAD2] = p->thread_length * p->thread_length;
    k[MCKIBBEN_FOUR_PI_TURNS2] = 4 * PI * p->turns * p->turns;
    k[MCKIBBEN_CORD] = p->cord_length, k[MCKIBBEN_TIME_CONSTANT] = p->pressure_time_constant;
}

/* Return the tension. If the path is shorter than the cord, the length of the bladder is zero, not negative. */
static real mckibben_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)v, (void)u;
    const real L = larger(l - k[MCKIBBEN_CORD], 0);
    return x[0] * (3 * L * L - k[MCKIBBEN_THREAD2]) / k[MCKIBBEN_FOUR_PI_TURNS2];
}

static void mckibben_rates(const real *k, const real *x, real l, real v, real u, real *xd)
{
    (void)l, (void)v;
    xd[0] = value_of(k[MCKIBBEN_TIME_CONSTANT]) > 0 ? (u - x[0]) / k[MCKIBBEN_TIME_CONSTANT] : 0;
}

static void mckibben_start(const real *k, real l, real u, real *x)
{
    (void)k, (void)l;
    x[0] = u;
}

static void mckibben_advance(const real *k, real *x, real l, real v, real u, real h)
{
    (void)l, (void)v;
    const real time = k[MCKIBBEN_TIME_CONSTANT];
    x[0] = value_of(time) > 0 ? u + (x[0] - u) * exponential(-h / time) : u;
}

TENSION_LAW(mckibben) = {
    .constants = MCKIBBEN_CONSTANTS,
    .prepare = mckibben_prepare,
    .tension = mckibben_tension,
    .rates = mckibben_rates,
    .start = mckibben_start,
    .advance = mckibben_advance,
};
