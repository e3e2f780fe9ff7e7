/* series_elastic_motor: a DC motor with gear and spindle that pulls on a spring.

   Current i, spindle speed w and angle theta, positive while reeling in; command: voltage V.

       La i'   = V - R i - Ke N w                     the armature; the motor turns N times as fast
       N J w'  = Kt i - r f / (rho N)                 torques on the motor's side, J = J_M + J_G
       theta'  = w
       f       = k (l - l0 + r theta), or 0 if that is negative

   rho is the gear's efficiency: eta while the motor drives the load, 1 / eta while the load drives the
   motor, with a smooth change in between as CARDSFlow's Gazebo plug-in has it:
   rho = eta + (1 / eta - eta) (tanh(-500 i w - 5) + 1) / 2.

   For a short time rho is constant, and so is whether the spring is taut: the equations are linear then
   and their Taylor series is summed up to rounding.                                                   */
#include "elementary.h"
#include "law.h"

#include <math.h>
#include <stddef.h>

enum { MOTOR_PARAMETERS(AT) PARAMETERS };
enum {
    ELECTRIC = LAW_OWN,   /* R / La */
    BACK_EMF,       /* Ke N / La */
    PER_INDUCTANCE, /* 1 / La */
    DRIVE,          /* Kt / (N J) */
    LOAD,           /* r / (N^2 J) */
    RADIUS,
    STIFFNESS,
    REST_LENGTH,
    EFFICIENCY,
    QUICKNESS, /* bound on how fast the states change, in [1/s] */
    STALL,     /* newtons a volt that hold at rest */
    PER_RESISTANCE,
    CONSTANTS
};
enum { CURRENT, SPEED, ANGLE, STATES };

/* With QUICKNESS x time at most this, so many terms of the series suffice. */
#define LARGEST_CHANGE 0.5
#define TERMS 18
#define LONGEST_SUBSTEP 1e-4
#define MOST_QUICKNESS 1e6
#define MOST_SUBSTEPS 1000000

static real quickness(const real *p)
{
    const real J = p[AT_gear_inertia] + p[AT_motor_inertia], N = p[AT_gear_ratio];
    const real R = p[AT_resistance] + p[AT_bridge_resistance], r = p[AT_spindle_radius];
    return R / p[AT_inductance] +
           sqrt(p[AT_back_emf_constant] * p[AT_torque_constant] / (p[AT_inductance] * J)) +
           sqrt(p[AT_stiffness] * r * r / (p[AT_gear_efficiency] * N * N * J));
}

static const char *refusal(const real *p)
{
    const int positive[] = {AT_resistance,    AT_inductance,     AT_torque_constant, AT_gear_ratio,
                            AT_motor_inertia, AT_spindle_radius, AT_stiffness,       AT_max_voltage};
    for (size_t i = 0; i < sizeof positive / sizeof *positive; i++)
        if (!(value_of(p[positive[i]]) > 0))
            return "resistance, inductance, torque_constant, gear_ratio, motor_inertia, "
                   "spindle_radius, stiffness and max_voltage must be positive";
    if (value_of(p[AT_bridge_resistance]) < 0 || value_of(p[AT_back_emf_constant]) < 0 ||
        value_of(p[AT_gear_inertia]) < 0)
        return "bridge_resistance, back_emf_constant and gear_inertia must not be negative";
    if (!(value_of(p[AT_gear_efficiency]) > 0 && value_of(p[AT_gear_efficiency]) <= 1))
        return "gear_efficiency must be above 0, and 1 at most";
    return value_of(quickness(p)) <= MOST_QUICKNESS ? NULL : "it changes faster than 1e6 a second";
}

static real efficiency(const real *k, real current, real speed)
{
    const real eta = k[EFFICIENCY];
    return eta + (1 / eta - eta) * (hyperbolic_tangent(-500 * current * speed - 5) + 1) / 2;
}

static void prepare(const real *p, real *k)
{
    const real J = p[AT_gear_inertia] + p[AT_motor_inertia], N = p[AT_gear_ratio];
    const real R = p[AT_resistance] + p[AT_bridge_resistance], La = p[AT_inductance];
    k[LAW_LOW] = -p[AT_max_voltage], k[LAW_HIGH] = p[AT_max_voltage];
    k[ELECTRIC] = R / La, k[BACK_EMF] = p[AT_back_emf_constant] * N / La, k[PER_INDUCTANCE] = 1 / La;
    k[DRIVE] = p[AT_torque_constant] / (N * J), k[LOAD] = p[AT_spindle_radius] / (N * N * J);
    k[RADIUS] = p[AT_spindle_radius], k[STIFFNESS] = p[AT_stiffness], k[REST_LENGTH] = p[AT_rest_length];
    k[EFFICIENCY] = p[AT_gear_efficiency], k[QUICKNESS] = quickness(p);
    k[PER_RESISTANCE] = 1 / R;
    k[STALL] = efficiency(k, 0, 0) * N * p[AT_torque_constant] / (R * p[AT_spindle_radius]);
}

static int states(const real *p)
{
    (void)p;
    return STATES;
}

static real elongation(const real *k, const real *x, real l)
{
    return l - k[REST_LENGTH] + k[RADIUS] * x[ANGLE];
}

static real tension(const real *k, const real *x, real l, real v, real u)
{
    (void)v, (void)u;
    return k[STIFFNESS] * larger(elongation(k, x, l), 0);
}

static void rates(const real *k, const real *x, real l, real v, real u, real *xd)
{
    const real rho = efficiency(k, x[CURRENT], x[SPEED]);
    xd[CURRENT] = k[PER_INDUCTANCE] * u - k[ELECTRIC] * x[CURRENT] - k[BACK_EMF] * x[SPEED];
    xd[SPEED] = k[DRIVE] * x[CURRENT] - k[LOAD] * tension(k, x, l, v, u) / rho;
    xd[ANGLE] = x[SPEED];
}

/* The motor stalls against the spring; one that pushes stands with a slack spring. */
static void start(const real *k, real l, real u, real *x)
{
    const real f = larger(k[STALL] * u, 0);
    x[CURRENT] = u * k[PER_RESISTANCE], x[SPEED] = 0;
    x[ANGLE] = (f / k[STIFFNESS] - (l - k[REST_LENGTH])) / k[RADIUS];
}

/* Every term of the series is the derivative of the last one: d' = A d, times t / n. Efficiency and
   tautness are those of the middle of the substep.                                                    */
static void substep(const real *k, real *x, real l, real v, real u, real t)
{
    real d[STATES], middle[STATES], stretched = v; /* the path's own part is in one term only */
    rates(k, x, l, v, u, d);
    for (int i = 0; i < STATES; i++) middle[i] = x[i] + d[i] * t / 2;
    const real taut = value_of(elongation(k, middle, l + v * t / 2)) > 0 ? k[STIFFNESS] : 0;
    const real load = taut * k[LOAD] / efficiency(k, middle[CURRENT], middle[SPEED]);
    d[SPEED] = k[DRIVE] * x[CURRENT] - load * elongation(k, x, l);
    for (int n = 1; n <= TERMS; n++) {
        const real part = t / n;
        for (int i = 0; i < STATES; i++) d[i] *= part, x[i] += d[i];
        const real current = -k[ELECTRIC] * d[CURRENT] - k[BACK_EMF] * d[SPEED];
        const real speed = k[DRIVE] * d[CURRENT] - load * (k[RADIUS] * d[ANGLE] + stretched * part);
        d[ANGLE] = d[SPEED], d[CURRENT] = current, d[SPEED] = speed;
        stretched = 0;
    }
}

static void advance(const real *k, real *x, real l, real v, real u, real h)
{
    const real wanted = ceil(h * larger(k[QUICKNESS] / LARGEST_CHANGE, 1 / LONGEST_SUBSTEP));
    const int steps = (int)clamped(wanted, 1, MOST_SUBSTEPS);
    const real t = h / steps;
    for (int i = 0; i < steps; i++) substep(k, x, l + v * t * i, v, u, t);
}

const tension_law LAW_MOTOR = {
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
