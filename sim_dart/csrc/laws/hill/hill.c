/* Hill-type muscles: rigid and elastic tendons. */
#include "hill.h"

#include "../../math/elementary.h"
#include "../../math/root.h"

#include <math.h>
#include <string.h>

/* First parameters of all Hill-type laws: all but one of those of Schutte. */
typedef hill_schutte1993_parameters hill_parameters;

/* Last step of Newton's method, in optimal fibre lengths and in maximum contraction velocities, and the
   shortest one, in optimal fibre lengths, which rounding still allows. */
#define LAST_HILL_STEP PRECISE(1e-8, 1e-4)
#define MIN_HILL_STEP PRECISE(1e-14, 1e-6)
/* Range of the search for fibre velocities, in maximum contraction velocities. */
#define MAX_VELOCITY 1e6
/* Of the search range for tendon lengths. */
#define MAX_DOUBLINGS 20

void hill_prepare(const void *parameters, real shortest, real steepest, real damping, real smoothing,
                  real *k)
{
    const hill_parameters *p = parameters;
    const real optimum = p->optimal_fibre_length;
    const real height = optimum * sine(p->pennation_at_optimal);
    k[HILL_FORCE] = p->max_isometric_force, k[HILL_OPTIMUM] = optimum;
    k[HILL_SLACK] = p->tendon_slack_length, k[HILL_HEIGHT2] = height * height;
    k[HILL_SPEED] = p->max_contraction_velocity * optimum, k[HILL_DAMPING] = damping;
    k[HILL_MIN_FIBRE] = larger(shortest * optimum, height / sine(steepest));
    k[HILL_MIN_PROJECTED] = sqrt(larger(k[HILL_MIN_FIBRE] * k[HILL_MIN_FIBRE] - k[HILL_HEIGHT2], 0));
    k[HILL_ELASTIC] = p->elastic_tendon;
    k[HILL_PER_OPTIMUM] = 1 / optimum, k[HILL_PER_SPEED] = 1 / k[HILL_SPEED];
    k[HILL_RISE] = 1 / p->activation_time_constant;
    k[HILL_FALL] = 1 / p->deactivation_time_constant;
    k[HILL_MIN_ACTIVATION] = p->minimum_activation, k[HILL_SMOOTHING] = smoothing;
}

/* Return the fibre force over F0, along the fibre, with its derivatives by fibre length [1/m] and velocity. */
static real fibre_force(const hill_curves *f, const real *k, real a, real fibre, real w,
                        real *by_length, real *by_velocity)
{
    const real z = clamped(fibre * k[HILL_PER_OPTIMUM], 0, HILL_MAX_NORMALISED);
    const real speed = f->speed ? f->speed(a) : 1;
    real active_slope, velocity_slope, passive_slope;
    const real active = f->active(k, z, &active_slope), passive = f->passive(k, z, &passive_slope);
    const real scaled = clamped(w / speed, -HILL_MAX_NORMALISED, HILL_MAX_NORMALISED);
    const real velocity = f->velocity(k, scaled, &velocity_slope);
    *by_length = (a * active_slope * velocity + passive_slope) * k[HILL_PER_OPTIMUM];
    *by_velocity = a * active * velocity_slope / speed + k[HILL_DAMPING];
    return a * active * velocity + passive + k[HILL_DAMPING] * w;
}

static real tendon_force(const hill_curves *f, const real *k, real tendon, real *slope)
{
    const real stretch = clamped(tendon / k[HILL_SLACK], 0, HILL_MAX_NORMALISED);
    if (value_of(stretch) <= 1) return *slope = 0;
    const real force = f->tendon(k, stretch, slope);
    *slope /= k[HILL_SLACK];
    return force;
}

static real projected_length(const real *k, real fibre)
{
    return sqrt(larger(fibre * fibre - k[HILL_HEIGHT2], 0));
}

real hill_elastic_tension(const hill_curves *f, const real *k, const real *x, real l)
{
    real slope;
    const real fibre = larger(x[1], k[HILL_MIN_FIBRE]);
    return k[HILL_FORCE] * tendon_force(f, k, l - projected_length(k, fibre), &slope);
}

/* Difference of the fibre force along the tendon and the tendon force, over F0. The fibre velocity is `w`;
   or, if `time` > 0, the velocity with which the fibre moves from `from` to its length in that time. */
typedef struct {
    const hill_curves *curves;
    const real *k;
    real a, l, w, from, time;
} balance;

static real excess_by_length(const void *data, real fibre, real *derivative)
{
    const balance *b = data;
    const real per_metre = value_of(b->time) > 0 ? b->k[HILL_PER_SPEED] / b->time : 0;
    const real w = (fibre - b->from) * per_metre, along = projected_length(b->k, fibre);
    const real cosine = larger(along / fibre, 1e-9);
    real by_length, by_velocity, tendon_slope;
    const real force = fibre_force(b->curves, b->k, b->a, fibre, w, &by_length, &by_velocity);
    const real tendon = tendon_force(b->curves, b->k, b->l - along, &tendon_slope);
    *derivative = (by_length + by_velocity * per_metre) * cosine +
                  force * b->k[HILL_HEIGHT2] / (fibre * fibre * fibre * cosine) + tendon_slope / cosine;
    return force * cosine - tendon;
}

static real excess_by_velocity(const void *data, real w, real *derivative)
{
    const balance *b = data;
    real by_length, tendon_slope;
    const real along = projected_length(b->k, b->from), cosine = along / b->from;
    const real force = fibre_force(b->curves, b->k, b->a, b->from, w, &by_length, derivative);
    *derivative *= cosine;
    return force * cosine - tendon_force(b->curves, b->k, b->l - along, &tendon_slope);
}

/* Return the fibre length at which the forces are in equilibrium. At `longest` the tendon is slack and the
   fibre does not push, so the difference is not negative there. */
static real balanced_length(const balance *b, real guess)
{
    const real *k = b->k, along = b->l - k[HILL_SLACK];
    const real taut = value_of(along) > 0 ? sqrt(along * along + k[HILL_HEIGHT2]) : 0;
    const int moves = value_of(b->time) > 0;
    const real longest = larger(larger(taut, moves ? b->from : 0), k[HILL_MIN_FIBRE]);
    const real last = LAST_HILL_STEP * (moves ? smaller(b->time * k[HILL_SPEED], k[HILL_OPTIMUM]) : k[HILL_OPTIMUM]);
    return bracketed_root(excess_by_length, b, k[HILL_MIN_FIBRE], longest,
                          clamped(guess, k[HILL_MIN_FIBRE], longest),
                          larger(last, MIN_HILL_STEP * k[HILL_OPTIMUM]));
}

void hill_start(const hill_curves *f, const real *k, real l, real u, real *x)
{
    x[0] = hill_activation(k, u);
    if (!k[HILL_ELASTIC]) return;
    const balance b = {f, k, x[0], l, 0, 0, 0};
    x[1] = balanced_length(&b, k[HILL_OPTIMUM]);
}

void hill_rates(const hill_curves *f, const real *k, const real *x, real l, real v, real u,
                real *xd)
{
    (void)v;
    xd[0] = activation_rate(k, x[0], u);
    if (!k[HILL_ELASTIC]) return;
    const balance b = {f, k, hill_activation(k, x[0]), l, 0, larger(x[1], k[HILL_MIN_FIBRE]), 0};
    real slope, w;
    if (value_of(excess_by_velocity(&b, -MAX_VELOCITY, &slope)) >= 0)
        w = -MAX_VELOCITY;
    else if (value_of(excess_by_velocity(&b, MAX_VELOCITY, &slope)) <= 0)
        w = MAX_VELOCITY;
    else
        w = bracketed_root(excess_by_velocity, &b, -MAX_VELOCITY, MAX_VELOCITY, 0, LAST_HILL_STEP);
    xd[1] = value_of(x[1]) <= value_of(k[HILL_MIN_FIBRE]) ? larger(w, 0) * k[HILL_SPEED] : w * k[HILL_SPEED];
}

void hill_settle(const hill_curves *f, const real *k, real *x, real l, real time)
{
    const real from = x[1];
    const balance b = {f, k, hill_activation(k, x[0]), l, 0, from, time};
    x[1] = balanced_length(&b, from);
}

/* Advance by two implicit stages of an L-stable method of order 2 (SDIRK2), which damps stiff components. A
   stage is a force equilibrium with the mean fibre velocity; it exists also for a muscle without activation
   and damping. */
void hill_advance_fibre(const hill_curves *f, const real *k, real *x, real early, real l, real v, real h)
{
    if (!k[HILL_ELASTIC] || !(value_of(h) > 0)) return;
    const real time = HILL_STAGE * h, fibre = larger(x[1], k[HILL_MIN_FIBRE]);
    const balance first = {f, k, early, l + v * time, 0, fibre, time};
    const real middle = balanced_length(&first, fibre);
    const real from = fibre + (1 - HILL_STAGE) / HILL_STAGE * (middle - fibre);
    const balance second = {f, k, x[0], l + v * h, 0, from, time};
    x[1] = balanced_length(&second, fibre + (middle - fibre) / HILL_STAGE);
}

void hill_advance(const hill_curves *f, const real *k, real *x, real l, real v, real u,
                  real h)
{
    const real a = x[0];
    x[0] = activation_after(k, a, u, h);
    if (k[HILL_ELASTIC]) hill_advance_fibre(f, k, x, activation_after(k, a, u, HILL_STAGE * h), l, v, h);
}

/* Difference of the tendon force over F0 and `force`, at the tendon length over its slack length. */
typedef struct {
    const hill_curves *curves;
    const real *k;
    real force;
} tendon_balance;

static real tendon_excess(const void *data, real stretch, real *derivative)
{
    const tendon_balance *b = data;
    return b->curves->tendon(b->k, stretch, derivative) - b->force;
}

void hill_tendon(const hill_curves *f, const real *k, const real *point, real *value)
{
    const tendon_balance b = {f, k, point[0]};
    real low = 1, high = 1.05, slope;
    for (int i = 0; i < MAX_DOUBLINGS && value_of(tendon_excess(&b, high, &slope)) < 0; i++)
        low = high, high += high - 1;
    const real stretch = bracketed_root(tendon_excess, &b, low, high, (low + high) / 2, PRECISE(1e-13, 1e-6));
    f->tendon(k, stretch, &slope);
    const real along = point[1] - k[HILL_SLACK] * stretch, fibre = sqrt(along * along + k[HILL_HEIGHT2]);
    value[0] = fibre, value[1] = -k[HILL_SLACK] / slope * along / fibre;
}

void hill_fibre(const hill_curves *f, const real *k, const real *point, real *value)
{
    const real a = point[0], fibre = larger(point[1], k[HILL_MIN_FIBRE]), force = k[HILL_FORCE];
    const real w = point[2] * k[HILL_PER_SPEED], along = projected_length(k, fibre);
    const real cosine = larger(along / fibre, 1e-9), z = fibre * k[HILL_PER_OPTIMUM];
    const real speed = f->speed ? f->speed(a) : 1;
    const real scaled = clamped(w / speed, -HILL_MAX_NORMALISED, HILL_MAX_NORMALISED);
    real slope, velocity_slope, by_length, by_velocity;
    const real active = f->active(k, z, &slope), velocity = f->velocity(k, scaled, &velocity_slope);
    const real net = fibre_force(f, k, a, fibre, w, &by_length, &by_velocity);
    const real speed_slope = f->speed ? f->speed(a + 1) - speed : 0; /* it is linear in a */
    const real tilt = k[HILL_HEIGHT2] / (fibre * fibre * fibre * cosine); /* of the cosine, by the length */
    value[0] = force * net * cosine;
    value[1] = force * cosine * active * (velocity - a * velocity_slope * scaled * speed_slope / speed);
    value[2] = force * (by_length * cosine + net * tilt);
    value[3] = force * by_velocity * k[HILL_PER_SPEED] * cosine;
    value[4] = force * tendon_force(f, k, point[3] - along, &slope);
    value[5] = -force * slope / cosine;
    value[6] = active, value[7] = velocity, value[8] = f->passive(k, z, &slope), value[9] = cosine;
    activation_inverse(k, a, point[4], value + 10);
    value[13] = fibre;
}

real hill_curve_by_name(const hill_curves *f, const real *k, const char *name, real x,
                        real *slope)
{
    if (!strcmp(name, "active_force_length")) return f->active(k, x, slope);
    if (!strcmp(name, "force_velocity")) return f->velocity(k, x, slope);
    if (!strcmp(name, "passive_force_length")) return f->passive(k, x, slope);
    if (!strcmp(name, "tendon_force_length")) return f->tendon(k, x, slope);
    return NAN;
}
