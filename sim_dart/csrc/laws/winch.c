/* winch and winch_position: a drum with gear and motor that winds up an elastic cable.

   Drum velocity w and angle theta, positive while reeling in. Command: the torque of the motor; for
   winch_position, the unstretched length of cable on the path, which a drive controls.

     J w'   = T - rho g - b w - Tc sgn w         about the axis of the drum; J = N^2 J_M + J_D
     theta' = w
     f      = EA e (1 + D e')                    never below 0; e = (l - l_u) / (l_u + l_lead)
     g      = f + EA e^2 / 2
     l_u    = l_0 - rho theta                    cable paid out, on the path; rho^2 = r^2 + (p / 2 pi)^2
     T      = N u,  or  Kp (l_u - u) / rho - Kd w,  within +-N T_max

   The cable stores E = EA (l - l_u)^2 / 2 (l_u + l_lead). f and g are its derivatives by l and by -l_u, so
   that motor, drum, cable and link exchange energy without loss if D, b and Tc are 0.

   A turn winds up a helix of pitch p. The cable leaves the drum at a fixed point, as from a drum that
   travels. In e' the stretched length l_u + l_lead is constant.

   A substep is the implicit midpoint rule, with dry friction according to the velocity at its end:

     J (w1 - w0) / t = G((w0 + w1) / 2) - Tc sgn w1,   theta1 = theta0 + t (w0 + w1) / 2

   G decreases with w: w1 is unique, and is 0 if friction holds the drum. */
#include "../math/elementary.h"
#include "law.h"

#include <math.h>

enum {
    WINCH_RADIUS = LAW_OWN, /* rho */
    WINCH_INERTIA,          /* J */
    WINCH_VISCOUS,
    WINCH_DRY,
    WINCH_AXIAL_STIFFNESS,
    WINCH_DISSIPATION,
    WINCH_LEAD,
    WINCH_REST_LENGTH,
    WINCH_GEAR,       /* drum torque per command; 0 with a drive */
    WINCH_MAX_TORQUE,       /* maximum torque of the drum */
    WINCH_PROPORTIONAL, /* of a drive, Kp; 0 without a drive */
    WINCH_DERIVATIVE,
    WINCH_CONSTANTS
};
enum { WINCH_SPEED, WINCH_ANGLE, WINCH_STATES };

/* Minimum length paid out, as a divisor, in [m]. */
static const real MIN_CABLE = PRECISE(1e-3, 1e-3);
static const real MAX_WINCH_STEP = 2.5e-4;
/* Maximum phase of the fastest oscillation of the drum in a substep, in [rad]. */
static const real MAX_WINCH_TURN = 0.05;
#define MAX_WINCH_STEPS 2000
#define MAX_WINCH_ITERATIONS 20
#define MAX_DRIVE_ITERATIONS 60
/* Last relative step of Newton's method: the remaining error is about its square; derivatives need a further
   step. */
static const real SPEED_TOLERANCE = HAS_TANGENT ? 1e-14 : PRECISE(1e-8, 1e-4);

static void winch_prepare(const void *parameters, real *k)
{
    const winch_parameters *p = parameters;
    const real N = p->gear_ratio, r = p->drum_radius, travel = p->drum_pitch / (2 * PI);
    k[WINCH_RADIUS] = sqrt(r * r + travel * travel);
    k[WINCH_INERTIA] = N * N * p->motor_inertia + p->drum_inertia;
    k[WINCH_VISCOUS] = p->viscous_friction, k[WINCH_DRY] = p->dry_friction;
    k[WINCH_AXIAL_STIFFNESS] = p->axial_stiffness, k[WINCH_DISSIPATION] = p->dissipation;
    k[WINCH_LEAD] = p->lead_length, k[WINCH_REST_LENGTH] = p->rest_length;
    k[WINCH_GEAR] = N, k[WINCH_MAX_TORQUE] = N * p->max_torque;
    k[WINCH_PROPORTIONAL] = k[WINCH_DERIVATIVE] = 0;
}

static void winch_position_prepare(const void *parameters, real *k)
{
    const winch_position_parameters *p = parameters;
    winch_prepare(parameters, k);
    k[WINCH_GEAR] = 0;
    k[WINCH_PROPORTIONAL] = p->position_gain, k[WINCH_DERIVATIVE] = p->velocity_gain;
}

static real paid_out(const real *k, real angle)
{
    return k[WINCH_REST_LENGTH] - k[WINCH_RADIUS] * angle;
}

static real stretched_length(const real *k, real angle)
{
    return larger(paid_out(k, angle) + k[WINCH_LEAD], MIN_CABLE);
}

/* Pull of a cable: f at its end, g at the drum with its slope by w, where the stretch grows by `reach` w. */
typedef struct {
    real f, g, slope;
} cable_pull;

/* Compute the pull of a cable of `length`, stretched by `over`, at the stretch rate v + rho w. */
static cable_pull pull_at(const real *k, real over, real length, real v, real w, real reach)
{
    cable_pull pull = {0, 0, 0};
    if (!(value_of(over) > 0)) return pull;
    const real e = over / length, stiff = k[WINCH_AXIAL_STIFFNESS], D = k[WINCH_DISSIPATION];
    const real damped = 1 + D * (v + k[WINCH_RADIUS] * w) / length, f = stiff * e * damped;
    pull.g = stiff * e * e / 2, pull.slope = stiff * e * reach / length;
    if (!(value_of(f) > 0)) return pull;
    pull.f = f, pull.g += f;
    pull.slope += stiff * (reach * damped + over * D * k[WINCH_RADIUS] / length) / length;
    if (value_of(pull.g) > MAX_TENSION)
        pull.f = smaller(f, MAX_TENSION), pull.g = MAX_TENSION, pull.slope = 0;
    return pull;
}

static cable_pull pull_of(const real *k, const real *x, real l, real v)
{
    const real over = l - paid_out(k, x[WINCH_ANGLE]);
    return pull_at(k, over, stretched_length(k, x[WINCH_ANGLE]), v, x[WINCH_SPEED], 0);
}

static real winch_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)u;
    return pull_of(k, x, l, v).f;
}

static cable_stretch winch_stretched(const real *k, const real *x, real l, real u)
{
    const real angle = x[WINCH_ANGLE], stiffness = k[WINCH_AXIAL_STIFFNESS] / stretched_length(k, angle);
    (void)u;
    return (cable_stretch){larger(l - paid_out(k, angle), 0), stiffness, k[WINCH_LEAD]};
}

/* Return the torque of the motor at the drum; its slope by w, where the angle grows by `reach` w. */
static real motor_torque(const real *k, real angle, real w, real u, real reach, real *slope)
{
    *slope = 0;
    if (value_of(k[WINCH_PROPORTIONAL]) == 0) return k[WINCH_GEAR] * u;
    const real Kp = k[WINCH_PROPORTIONAL], Kd = k[WINCH_DERIVATIVE];
    const real T = Kp * ((paid_out(k, angle) - u) / k[WINCH_RADIUS]) - Kd * w, maximum = k[WINCH_MAX_TORQUE];
    if (value_of(fabs(T)) >= value_of(maximum)) return value_of(T) > 0 ? maximum : -maximum;
    *slope = -Kp * reach - Kd;
    return T;
}

static void winch_rates(const real *k, const real *x, real l, real v, real u, real *xd)
{
    real slope;
    const real w = x[WINCH_SPEED], dry = k[WINCH_DRY];
    real torque = motor_torque(k, x[WINCH_ANGLE], w, u, 0, &slope) - k[WINCH_VISCOUS] * w -
                  k[WINCH_RADIUS] * pull_of(k, x, l, v).g;
    if (value_of(w) != 0) torque -= value_of(w) > 0 ? dry : -dry;
    else torque -= clamped(torque, -dry, dry);
    xd[WINCH_SPEED] = torque / k[WINCH_INERTIA];
    xd[WINCH_ANGLE] = w;
}

/* Return the length paid out at which the drum holds a pull g at a path length l: g = EA ((1 + e)^2 - 1) /
   2. */
static real paid_out_for_pull(const real *k, real l, real g)
{
    return (l + k[WINCH_LEAD]) / sqrt(1 + 2 * g / k[WINCH_AXIAL_STIFFNESS]) - k[WINCH_LEAD];
}

/* Return the length paid out at which a drive within its limits is in equilibrium, Kp (l_u - u) / rho^2 = g,
   or u of a slack cable. Solved for s = (l_u + l_lead) / (l + l_lead) from 1, where the residual is convex. */
static real paid_out_for_command(const real *k, real l, real u)
{
    if (value_of(u) >= value_of(l)) return u;
    const real rho = k[WINCH_RADIUS], maximum = l + k[WINCH_LEAD], minimum = (u + k[WINCH_LEAD]) / maximum;
    const real a = 2 * k[WINCH_PROPORTIONAL] * maximum / (rho * rho * k[WINCH_AXIAL_STIFFNESS]);
    real s = 1;
    for (int i = 0; i < MAX_DRIVE_ITERATIONS; i++) {
        const real over = (a * (s - minimum) + 1) * s * s - 1;
        const real step = over / (2 * (a * (s - minimum) + 1) * s + a * s * s);
        s -= step;
        if (value_of(fabs(step)) <= PRECISE(1e-14, 1e-6) * value_of(s)) break;
    }
    return maximum * s - k[WINCH_LEAD];
}

/* Compute the states of a drum at rest: the motor holds the cable, or the cable is slack. Dry friction
   carries no load. */
static void winch_start(const real *k, real l, real u, real *x)
{
    const real rho = k[WINCH_RADIUS], strongest = k[WINCH_MAX_TORQUE] / rho;
    real paid;
    if (value_of(k[WINCH_PROPORTIONAL]) == 0) {
        paid = paid_out_for_pull(k, l, larger(k[WINCH_GEAR] * u / rho, 0));
    } else {
        paid = paid_out_for_command(k, l, u);
        const real minimum_paid = paid_out_for_pull(k, l, strongest);
        if (value_of(k[WINCH_PROPORTIONAL] * (paid - u)) > value_of(k[WINCH_MAX_TORQUE] * rho)) paid = minimum_paid;
    }
    x[WINCH_SPEED] = 0, x[WINCH_ANGLE] = (k[WINCH_REST_LENGTH] - paid) / rho;
}

/* Return the command of a drive that holds f at the current position of the drum; it is valid within a step
   in which the drive stays within its limits. */
static real winch_guess(const real *k, const real *x, real l, real f, real *step)
{
    const real rho = k[WINCH_RADIUS], Kp = k[WINCH_PROPORTIONAL];
    (void)l;
    *step = rho * k[WINCH_MAX_TORQUE] / (10 * Kp);
    return paid_out(k, x[WINCH_ANGLE]) - rho * (rho * f + k[WINCH_DERIVATIVE] * x[WINCH_SPEED]) / Kp;
}

/* State at the start of a substep of time t. */
typedef struct {
    real l, v, u, t, length;
    const real *x;
} winch_substep;

/* Return G and its slope by w1. */
static real drum_torque(const real *k, const winch_substep *s, real w1, real *slope)
{
    const real w = (s->x[WINCH_SPEED] + w1) / 2, rho = k[WINCH_RADIUS];
    const real angle = s->x[WINCH_ANGLE] + s->t * w / 2, over = s->l + s->v * s->t / 2 - paid_out(k, angle);
    real by_motor;
    const real T = motor_torque(k, angle, w, s->u, s->t / 2, &by_motor);
    const cable_pull pull = pull_at(k, over, s->length, s->v, w, rho * s->t / 2);
    *slope = (by_motor - rho * pull.slope - k[WINCH_VISCOUS]) / 2;
    return T - rho * pull.g - k[WINCH_VISCOUS] * w;
}

/* Compute w1 by Newton's method. The equation is not linear due to a cable that gets taut, a drive at its
   limit and D. */
static real solve_speed(const real *k, const winch_substep *s)
{
    const real heavy = k[WINCH_INERTIA] / s->t, w0 = s->x[WINCH_SPEED];
    real slope, w = 0;
    const real pushed = heavy * w0 + drum_torque(k, s, w, &slope);
    if (value_of(fabs(pushed)) <= value_of(k[WINCH_DRY])) return 0;
    const real braked = value_of(pushed) > 0 ? -k[WINCH_DRY] : k[WINCH_DRY];
    real left = pushed + braked;
    for (int i = 0; i < MAX_WINCH_ITERATIONS; i++) {
        const real step = left / (heavy - slope);
        w += step;
        if (value_of(fabs(step)) <= value_of(SPEED_TOLERANCE * (fabs(w) + fabs(w0)))) break;
        left = heavy * (w0 - w) + drum_torque(k, s, w, &slope) + braked;
    }
    return w;
}

static void winch_advance_substep(const real *k, real *x, real l, real v, real u, real t)
{
    const winch_substep s = {l, v, u, t, stretched_length(k, x[WINCH_ANGLE] + t * x[WINCH_SPEED] / 2), x};
    const real w1 = solve_speed(k, &s);
    x[WINCH_ANGLE] += t * (x[WINCH_SPEED] + w1) / 2;
    x[WINCH_SPEED] = w1;
}

static void winch_advance(const real *k, real *x, real l, real v, real u, real h)
{
    const real rho = k[WINCH_RADIUS];
    const real holding = k[WINCH_AXIAL_STIFFNESS] * rho * rho / stretched_length(k, x[WINCH_ANGLE]);
    const real quick = sqrt((holding + k[WINCH_PROPORTIONAL]) / k[WINCH_INERTIA]);
    const real minimum = ceil(h * larger(quick / MAX_WINCH_TURN, 1 / MAX_WINCH_STEP));
    const int steps = whole_steps(minimum, MAX_WINCH_STEPS);
    const real t = h / steps;
    for (int i = 0; i < steps; i++) winch_advance_substep(k, x, l + v * t * i, v, u, t);
}

TENSION_LAW(winch) = {
    .constants = WINCH_CONSTANTS,
    .is_rough = 1,
    .prepare = winch_prepare,
    .tension = winch_tension,
    .stretch = winch_stretched,
    .rates = winch_rates,
    .start = winch_start,
    .advance = winch_advance,
};

TENSION_LAW(winch_position) = {
    .constants = WINCH_CONSTANTS,
    .is_rough = 1,
    .moves_along = 1,
    .prepare = winch_position_prepare,
    .tension = winch_tension,
    .stretch = winch_stretched,
    .rates = winch_rates,
    .start = winch_start,
    .advance = winch_advance,
    .guess = winch_guess,
};
