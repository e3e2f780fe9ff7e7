/* hill_millard2012: curves of Bezier pieces, with or without fibre damping.

   Millard, Uchida, Seth & Delp 2013, J. Biomech. Eng. 135: Flexing computational muscle. The knots are those
   of OpenSim's Millard2012EquilibriumMuscle. */
#include "../../math/elementary.h"
#include "bezier.h"
#include "hill.h"

#include <math.h>
#include <stddef.h>

enum { ACTIVE_PIECES = 5, VELOCITY_PIECES = 4, PASSIVE_PIECES = 2, TENDON_PIECES = 2 };
enum {
    MILLARD_ACTIVE = HILL_CONSTANTS,
    MILLARD_VELOCITY = MILLARD_ACTIVE + BEZIER_SIZE(ACTIVE_PIECES),
    MILLARD_PASSIVE = MILLARD_VELOCITY + BEZIER_SIZE(VELOCITY_PIECES),
    MILLARD_TENDON = MILLARD_PASSIVE + BEZIER_SIZE(PASSIVE_PIECES),
    MILLARD_CONSTANTS = MILLARD_TENDON + BEZIER_SIZE(TENDON_PIECES)
};

/* Fibre damping below this value is ignored. */
static const real MIN_DAMPING = 0.001;

static void set_knot(real *knot, real x, real y, real slope)
{
    knot[0] = x, knot[1] = y, knot[2] = slope;
}

/* Return whether the law divides by a curve: with an elastic tendon and without fibre damping the velocity
   is computed from the force, so no curve may be flat or zero. */
static int is_singular(const hill_millard2012_parameters *p)
{
    return p->elastic_tendon != 0 && value_of(p->fibre_damping) < value_of(MIN_DAMPING);
}

/* Prepare five pieces: steep rise, slow rise, plateau, descent, tail. */
static void prepare_active(const hill_millard2012_parameters *p, real *curve)
{
    const real least = is_singular(p) ? larger(p->active_minimum, 0.1) : p->active_minimum;
    const real begin = p->active_shortest, turn = p->active_transition, end = p->active_longest;
    const real slow = p->active_shallow_slope, half_plateau = 0.05, shoulder = 1 - half_plateau;
    const real at_turn = 1 - slow * (shoulder - turn), steep = 1.25 * at_turn / (turn - begin);
    const real fall = -1 / ((end - half_plateau) - (1 + half_plateau));
    set_knot(curve, begin, least, 0);
    set_knot(curve + 3, 0.5 * (begin + turn), 0.5 * at_turn, steep);
    set_knot(curve + 6, 0.5 * (turn + shoulder), 0.5 * (1 + at_turn), slow);
    set_knot(curve + 9, 1, 1, 0);
    set_knot(curve + 12, 0.5 * (1 + half_plateau + end), 0.5, fall);
    set_knot(curve + 15, end, least, 0);
}

static void prepare_velocity(const hill_millard2012_parameters *p, real *curve)
{
    const real near = 0.9, least = is_singular(p) ? 0.5 : 0; /* share of the slope near vmax */
    const real shorten_near = p->concentric_slope_near_vmax;
    const real lengthen_near = p->eccentric_slope_near_vmax, most = p->eccentric_force;
    const real shorten = larger(p->concentric_slope_at_vmax, least * shorten_near);
    const real lengthen = larger(p->eccentric_slope_at_vmax, least * lengthen_near);
    set_knot(curve, -1, 0, shorten);
    set_knot(curve + 3, -near, 0.5 * (shorten_near + shorten) * (1 - near), shorten_near);
    set_knot(curve + 6, 0, 1, p->isometric_slope);
    set_knot(curve + 9, near, most - 0.5 * (lengthen_near + lengthen) * (1 - near), lengthen_near);
    set_knot(curve + 12, 1, most, lengthen);
}

static void prepare_passive(const hill_millard2012_parameters *p, real *curve)
{
    const real zero = 1 + p->passive_zero_strain, one = 1 + p->passive_fibre_strain;
    const real steep = value_of(p->passive_stiffness) > 0 ? p->passive_stiffness : 2 / (one - zero);
    const real toe = smaller(0.1 / steep, 0.1 * (one - zero)), low = p->passive_stiffness_low;
    set_knot(curve, zero, 0, 0);
    set_knot(curve + 3, zero + toe, low * toe / 2, low);
    set_knot(curve + 6, one, 1, steep);
}

/* Prepare a toe of two pieces; the straight line after it reaches F0 at the strain of the tendon. */
static void prepare_tendon(const hill_millard2012_parameters *p, real *curve)
{
    const real strain = p->tendon_strain, toe = p->tendon_toe_force;
    const real steep = value_of(p->tendon_stiffness) > 0 ? p->tendon_stiffness : 1.375 / strain;
    const real one = 1 + strain, at_toe = (toe - 1) / steep + one, foot = 1 + (at_toe - 1) / 10;
    const real at_half = (toe / 2 - 1) / steep + one, slope = toe / 2 / (at_half - foot);
    set_knot(curve, 1, 0, 0);
    set_knot(curve + 3, foot + 0.5 * (at_half - foot), toe / 4, slope);
    set_knot(curve + 6, at_toe, toe, steep);
}

static void prepare_curves(const hill_millard2012_parameters *p, real *k)
{
    const real shortening = p->concentric_curviness, lengthening = p->eccentric_curviness;
    prepare_active(p, k + MILLARD_ACTIVE);
    bezier_prepare(k + MILLARD_ACTIVE, ACTIVE_PIECES, (const real[]){1, 1, 1, 1, 1});
    prepare_velocity(p, k + MILLARD_VELOCITY);
    bezier_prepare(k + MILLARD_VELOCITY, VELOCITY_PIECES,
                   (const real[]){shortening, shortening, lengthening, lengthening});
    prepare_passive(p, k + MILLARD_PASSIVE);
    bezier_prepare(k + MILLARD_PASSIVE, PASSIVE_PIECES,
                   (const real[]){p->passive_curviness, p->passive_curviness});
    prepare_tendon(p, k + MILLARD_TENDON);
    bezier_prepare(k + MILLARD_TENDON, TENDON_PIECES,
                   (const real[]){p->tendon_curviness, p->tendon_curviness});
}

/* Check that no piece of a curve turns back, which the bounds of the parameters cannot guarantee. */
static const char *millard_check_curves(const void *parameters)
{
    real k[MILLARD_CONSTANTS];
    prepare_curves(parameters, k);
    if (!bezier_is_sound(k + MILLARD_ACTIVE, ACTIVE_PIECES))
        return "the active force-length curve turns back; see its lengths and slope";
    if (!bezier_is_sound(k + MILLARD_VELOCITY, VELOCITY_PIECES))
        return "the force-velocity curve turns back; see its slopes and eccentric_force";
    if (!bezier_is_sound(k + MILLARD_PASSIVE, PASSIVE_PIECES))
        return "the passive force-length curve turns back; see its strains and stiffnesses";
    if (!bezier_is_sound(k + MILLARD_TENDON, TENDON_PIECES))
        return "the tendon curve turns back; see its strain, stiffness and toe";
    return NULL;
}

static real millard_active(const real *k, real x, real *slope)
{
    return bezier_value(law_shared(k) + MILLARD_ACTIVE, ACTIVE_PIECES, x, slope);
}

static real millard_velocity(const real *k, real x, real *slope)
{
    return bezier_value(law_shared(k) + MILLARD_VELOCITY, VELOCITY_PIECES, x, slope);
}

static real millard_passive(const real *k, real x, real *slope)
{
    return bezier_value(law_shared(k) + MILLARD_PASSIVE, PASSIVE_PIECES, x, slope);
}

static real millard_tendon(const real *k, real x, real *slope)
{
    return bezier_value(law_shared(k) + MILLARD_TENDON, TENDON_PIECES, x, slope);
}

static void millard_prepare(const void *parameters, real *k)
{
    const hill_millard2012_parameters *p = parameters;
    const real damping = value_of(p->fibre_damping) < value_of(MIN_DAMPING) ? 0 : p->fibre_damping;
    hill_prepare(parameters, p->active_shortest, p->maximum_pennation, damping, 0, k);
    if (is_singular(p)) k[HILL_MIN_ACTIVATION] = larger(k[HILL_MIN_ACTIVATION], 0.01);
    prepare_curves(p, k);
}

static real millard_product(const real *k, real z, real w, real *passive)
{
    const real *shared = law_shared(k);
    const bezier_point of[BEZIER_POINTS] = {{shared + MILLARD_ACTIVE, ACTIVE_PIECES, z},
                                            {shared + MILLARD_VELOCITY, VELOCITY_PIECES, w},
                                            {shared + MILLARD_PASSIVE, PASSIVE_PIECES, z}};
    real y[BEZIER_POINTS];
    bezier_values(of, y);
    *passive = y[2];
    return y[0] * y[1];
}

static const hill_curves millard_curves = {millard_active, millard_velocity, millard_passive,
                                           millard_tendon, NULL,             millard_product};
HILL_FUNCTIONS(millard)

/* First constant that the curves depend on: whether the tendon is elastic. */
TENSION_LAW(hill_millard2012) = {
    HILL_LAW(millard, MILLARD_CONSTANTS),
    .check = WHEN_OPENED(millard_check_curves),
    .shared_from = offsetof(hill_millard2012_parameters, elastic_tendon) / sizeof(real),
};
