/* series_elastic_motor: a DC motor with gear and spindle that pulls a spring.

   Current i, spindle velocity w and angle theta, positive while reeling in; command: voltage V.

     La i'   = V - R i - Ke N w                     armature; the motor turns N times as fast as the spindle
     N J w'  = Kt i - r f / (rho N)                 torques at the motor, J = J_M + J_G
     theta'  = w
     f       = k (l - l0 + r theta), or 0 if this is negative

   rho is the efficiency of the gear: eta while the motor drives the load, 1 / eta while the load drives the
   motor, with the smooth transition of CARDSFlow's Gazebo plug-in:

     rho = eta + (1 / eta - eta) (tanh(-500 i w - 5) + 1) / 2.

   During a short time, rho and the tautness of the spring are constant. The equations are then linear, and
   their Taylor series is summed up to rounding. */
#include "../math/elementary.h"
#include "law.h"

#include <math.h>

enum {
    MOTOR_ELECTRIC = LAW_OWN, /* R / La */
    MOTOR_BACK_EMF,           /* Ke N / La */
    MOTOR_PER_INDUCTANCE,     /* 1 / La */
    MOTOR_DRIVE,              /* Kt / (N J) */
    MOTOR_LOAD,               /* r / (N^2 J) */
    MOTOR_RADIUS,
    MOTOR_STIFFNESS,
    MOTOR_REST_LENGTH,
    MOTOR_EFFICIENCY,
    MOTOR_MAX_RATE, /* bound of the rate of the states, in [1/s] */
    MOTOR_STALL,     /* force per volt at rest, in [N/V] */
    MOTOR_PER_RESISTANCE,
    MOTOR_CONSTANTS
};
enum { CURRENT, SPEED, ANGLE, MOTOR_STATES };

/* Maximum of MOTOR_MAX_RATE x time for which the terms of the series suffice. */
#define MAX_CHANGE 0.5
#define TERMS 18
#define MAX_SUBSTEP 1e-4
#define MAX_SUBSTEPS 1000000

static real efficiency(const real *k, real current, real speed)
{
    const real eta = k[MOTOR_EFFICIENCY];
    return eta + (1 / eta - eta) * (hyperbolic_tangent(-500 * current * speed - 5) + 1) / 2;
}

static void motor_prepare(const void *parameters, real *k)
{
    const series_elastic_motor_parameters *p = parameters;
    const real J = series_elastic_motor_J(p), N = p->gear_ratio;
    const real R = p->resistance + p->bridge_resistance, La = p->inductance;
    k[MOTOR_ELECTRIC] = R / La, k[MOTOR_PER_INDUCTANCE] = 1 / La;
    k[MOTOR_BACK_EMF] = p->back_emf_constant * N / La;
    k[MOTOR_DRIVE] = p->torque_constant / (N * J), k[MOTOR_LOAD] = p->spindle_radius / (N * N * J);
    k[MOTOR_RADIUS] = p->spindle_radius, k[MOTOR_STIFFNESS] = p->stiffness;
    k[MOTOR_REST_LENGTH] = p->rest_length;
    k[MOTOR_EFFICIENCY] = p->gear_efficiency, k[MOTOR_MAX_RATE] = series_elastic_motor_quickness(p);
    k[MOTOR_PER_RESISTANCE] = 1 / R;
    k[MOTOR_STALL] = efficiency(k, 0, 0) * N * p->torque_constant / (R * p->spindle_radius);
}

static real elongation(const real *k, const real *x, real l)
{
    return l - k[MOTOR_REST_LENGTH] + k[MOTOR_RADIUS] * x[ANGLE];
}

static real motor_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)v, (void)u;
    return k[MOTOR_STIFFNESS] * larger(elongation(k, x, l), 0);
}

static void motor_rates(const real *k, const real *x, real l, real v, real u, real *xd)
{
    const real rho = efficiency(k, x[CURRENT], x[SPEED]);
    xd[CURRENT] = k[MOTOR_PER_INDUCTANCE] * u - k[MOTOR_ELECTRIC] * x[CURRENT] - k[MOTOR_BACK_EMF] * x[SPEED];
    xd[SPEED] = k[MOTOR_DRIVE] * x[CURRENT] - k[MOTOR_LOAD] * motor_tension(k, x, l, v, u) / rho;
    xd[ANGLE] = x[SPEED];
}

/* Compute the states at rest: the motor stalls against the spring; with a negative torque the spring is
   slack. */
static void motor_start(const real *k, real l, real u, real *x)
{
    const real f = larger(k[MOTOR_STALL] * u, 0);
    x[CURRENT] = u * k[MOTOR_PER_RESISTANCE], x[SPEED] = 0;
    x[ANGLE] = (f / k[MOTOR_STIFFNESS] - (l - k[MOTOR_REST_LENGTH])) / k[MOTOR_RADIUS];
}

/* Compute a substep. Each term of the series is the derivative of the previous one: d' = A d, times t / n.
   Efficiency and tautness are those at the middle of the substep. */
static void substep(const real *k, real *x, real l, real v, real u, real t)
{
    real d[MOTOR_STATES], middle[MOTOR_STATES], stretched = v; /* the path contributes to one term only */
    motor_rates(k, x, l, v, u, d);
    for (int i = 0; i < MOTOR_STATES; i++) middle[i] = x[i] + d[i] * t / 2;
    const real taut = value_of(elongation(k, middle, l + v * t / 2)) > 0 ? k[MOTOR_STIFFNESS] : 0;
    const real load = taut * k[MOTOR_LOAD] / efficiency(k, middle[CURRENT], middle[SPEED]);
    d[SPEED] = k[MOTOR_DRIVE] * x[CURRENT] - load * elongation(k, x, l);
    for (int n = 1; n <= TERMS; n++) {
        const real part = t / n;
        for (int i = 0; i < MOTOR_STATES; i++) d[i] *= part, x[i] += d[i];
        const real current = -k[MOTOR_ELECTRIC] * d[CURRENT] - k[MOTOR_BACK_EMF] * d[SPEED];
        const real speed = k[MOTOR_DRIVE] * d[CURRENT] - load * (k[MOTOR_RADIUS] * d[ANGLE] + stretched * part);
        d[ANGLE] = d[SPEED], d[CURRENT] = current, d[SPEED] = speed;
        stretched = 0;
    }
}

static void motor_advance(const real *k, real *x, real l, real v, real u, real h)
{
    const real least = ceil(h * larger(k[MOTOR_MAX_RATE] / MAX_CHANGE, 1 / MAX_SUBSTEP));
    const int steps = whole_steps(least, MAX_SUBSTEPS);
    const real t = h / steps;
    for (int i = 0; i < steps; i++) substep(k, x, l + v * t * i, v, u, t);
}

TENSION_LAW(series_elastic_motor) = {
    .constants = MOTOR_CONSTANTS,
    .prepare = motor_prepare,
    .tension = motor_tension,
    .rates = motor_rates,
    .start = motor_start,
    .advance = motor_advance,
};
