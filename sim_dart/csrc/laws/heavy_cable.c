/* heavy_cable: an elastic cable that hangs between two points by its weight, always in static equilibrium.

   Elastic catenary (Irvine 1981, Cable Structures, eqs. 1.37 to 1.44) of a cable with the unstretched length
   L, the weight w per length and the stiffness EA, over a horizontal span a and a rise b. With the tensions
   T_1, T_2 at its ends and W = w L, tanh x = W / (T_1 + T_2); x is the only zero of

     (b / (1 + kappa coth x))^2 + (a sinh x / (kappa + x))^2 = L^2,    kappa = W / 2 EA
     H = w a / 2 (kappa + x)                 horizontal force
     V = w b / 2 (kappa + tanh x) -+ W / 2   vertical force at the lower and at the upper point

   The tension f = w l / 2 (kappa + x) along the chord l = sqrt(a^2 + b^2) contains H. The remaining vertical
   force pulls both points down. For a cable without weight the limit is f = EA (l / L - 1). */
#include "../math/elementary.h"
#include "../math/root.h"
#include "../math/vectors.h"
#include "law.h"

#include <math.h>

enum {
    HEAVY_STIFFNESS = LAW_OWN, /* EA */
    HEAVY_MASS,
    HEAVY_DAMPING,
    HEAVY_WEIGHT, /* w */
    HEAVY_RUN,    /* a / l */
    HEAVY_RISE,   /* b / l */
    HEAVY_CONSTANTS
};

/* Relative to the chord: minimum horizontal span, for a vertical cable. */
static const real MIN_RUN = PRECISE(1e-12, 1e-6);
/* Minimum chord, in [m]. */
static const real MIN_CHORD = 1e-6;
/* Maximum l / L. */
static const real MAX_DRAW = 2;
/* In [N]: a cable with less weight is weightless. */
static const real MIN_WEIGHT = PRECISE(1e-200, 1e-25);
static const real MAX_SLACK = PRECISE(80, 35); /* maximum x */
static const real ENOUGH_OF_SLACK = PRECISE(1e-9, 1e-4);

static void heavy_prepare(const void *parameters, real *k)
{
    const heavy_cable_parameters *p = parameters;
    k[HEAVY_STIFFNESS] = p->axial_stiffness, k[HEAVY_MASS] = p->mass_per_length;
    k[HEAVY_DAMPING] = p->damping;
    k[HEAVY_WEIGHT] = k[HEAVY_RISE] = 0, k[HEAVY_RUN] = 1;
}

static void heavy_place(real *k, const real chord[3], const real gravity[3])
{
    const real g = sqrt(dot3(gravity, gravity)), l = sqrt(dot3(chord, chord));
    k[HEAVY_WEIGHT] = k[HEAVY_MASS] * g, k[HEAVY_RISE] = 0, k[HEAVY_RUN] = 1;
    if (!(value_of(g) > 0) || !(value_of(l) > 0)) return;
    const real b = -dot3(chord, gravity) / g;
    real level[3];
    for (int i = 0; i < 3; i++) level[i] = chord[i] + b / g * gravity[i];
    k[HEAVY_RISE] = b / l, k[HEAVY_RUN] = larger(sqrt(dot3(level, level)) / l, MIN_RUN);
}

/* Geometry of a cable: a / L, b / L, l, L, kappa, w; whether it has weight. */
typedef struct {
    real run, rise, l, rest, kappa, w;
    int is_heavy;
} hanging;

static hanging hanging_geometry(const real *k, real l, real u)
{
    hanging at;
    at.l = larger(l, MIN_CHORD), at.rest = larger(u, at.l / MAX_DRAW);
    at.run = k[HEAVY_RUN] * at.l / at.rest, at.rise = k[HEAVY_RISE] * at.l / at.rest;
    at.w = k[HEAVY_WEIGHT];
    at.kappa = at.w * at.rest / (2 * k[HEAVY_STIFFNESS]);
    at.is_heavy = value_of(at.w * at.rest) > value_of(MIN_WEIGHT);
    return at;
}

/* Return the logarithm of the square root of the left side over L, at x = e^z. */
static real length_residual(const void *data, real z, real *slope)
{
    const hanging *at = data;
    const real x = exponential(z), m = exponential_less_one(x), kappa = at->kappa;
    const real s = (m + m / (m + 1)) / 2, c = 1 + m * m / (2 * (m + 1)); /* sinh, cosh */
    const real drawn = s + kappa * c, spread = kappa + x;
    const real up = at->rise * s / drawn, along = at->run * s / spread;
    const real square = up * up + along * along;
    const real by_x = up * (at->rise / drawn) * (kappa / drawn) + along * (at->run / spread) * (c - s / spread);
    *slope = x * by_x / square;
    return logarithm(square) / 2;
}

/* Compute x. The first guess is the tension of the parabola for three cases: taut, as long as the chord,
   slack. */
static real solve_slack(const real *k, const hanging *at)
{
    const real EA = k[HEAVY_STIFFNESS], W = at->w * at->rest, over = at->l / at->rest - 1;
    const real level = k[HEAVY_RUN] * W, taut = 2 * EA * larger(over, 0);
    real sagged = exponential(logarithm(EA * level * level / 24) / 3);
    if (value_of(over) < 0) sagged = smaller(sagged, level / sqrt(-24 * over));
    const real high = logarithm(MAX_SLACK), low = logarithm(W / (8 * EA + 2 * W));
    const real guess = logarithm(W / (taut + 2 * sagged));
    return exponential(bracketed_root(length_residual, at, low, high, clamped(guess, low, high), ENOUGH_OF_SLACK));
}

static real heavy_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)x;
    const hanging at = hanging_geometry(k, l, u);
    const real damping = k[HEAVY_DAMPING] * v;
    if (!at.is_heavy) return larger(k[HEAVY_STIFFNESS] * (at.l / at.rest - 1), 0) + damping;
    return at.w * at.l / (2 * (at.kappa + solve_slack(k, &at))) + damping;
}

static void heavy_weigh(const real *k, real l, real u, real down[2])
{
    const hanging at = hanging_geometry(k, l, u);
    down[0] = down[1] = 0;
    if (!at.is_heavy) return;
    const real x = solve_slack(k, &at), t = hyperbolic_tangent(x), half = at.w * at.rest / 2;
    const real steep = half * at.rise * (x - t) / ((at.kappa + t) * (at.kappa + x));
    down[0] = half - steep, down[1] = half + steep;
}

/* Return the length of the parabola without stretch. */
static real heavy_guess(const real *k, const real *state, real l, real f, real *step)
{
    (void)state;
    *step = l / 1000;
    const real x = k[HEAVY_WEIGHT] * k[HEAVY_RUN] * l / (2 * larger(f, MIN_WEIGHT));
    return l * (1 + x * x / 6) / (1 + f / k[HEAVY_STIFFNESS]);
}

TENSION_LAW(heavy_cable) = {
    .constants = HEAVY_CONSTANTS,
    .is_rough = 1,
    .prepare = heavy_prepare,
    .tension = heavy_tension,
    .place = heavy_place,
    .weigh = heavy_weigh,
    .guess = heavy_guess,
};
