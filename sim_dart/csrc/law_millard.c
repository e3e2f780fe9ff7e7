/* hill_millard2012: curves of Bezier pieces, with or without fibre damping.

   Millard, Uchida, Seth & Delp 2013, J. Biomech. Eng. 135: Flexing computational muscle. Where the knots
   lie follows OpenSim's Millard2012EquilibriumMuscle.                                                 */
#include "elementary.h"
#include "bezier.h"
#include "hill.h"

#include <math.h>
#include <stddef.h>

enum { MILLARD_PARAMETERS(AT) PARAMETERS };
enum { ACTIVE_PIECES = 5, VELOCITY_PIECES = 4, PASSIVE_PIECES = 2, TENDON_PIECES = 2 };
enum {
    ACTIVE = HILL_CONSTANTS,
    VELOCITY = ACTIVE + BEZIER_SIZE(ACTIVE_PIECES),
    PASSIVE = VELOCITY + BEZIER_SIZE(VELOCITY_PIECES),
    TENDON = PASSIVE + BEZIER_SIZE(PASSIVE_PIECES),
    CONSTANTS = TENDON + BEZIER_SIZE(TENDON_PIECES)
};

/* Below this, fibre damping counts as none. */
static const real LEAST_DAMPING = 0.001;

static void set_knot(real *knot, real x, real y, real slope)
{
    knot[0] = x, knot[1] = y, knot[2] = slope;
}

/* An elastic tendon without fibre damping takes the velocity from the force, so no curve may be flat or
   zero then.                                                                                          */
static int is_singular(const real *p)
{
    return p[AT_elastic_tendon] != 0 && value_of(p[AT_fibre_damping]) < value_of(LEAST_DAMPING);
}

/* Five elbows: up steeply, up slowly, over the top, down, out. */
static void prepare_active(const real *p, real *curve)
{
    const real least = is_singular(p) ? larger(p[AT_active_minimum], 0.1) : p[AT_active_minimum];
    const real begin = p[AT_active_shortest], turn = p[AT_active_transition], end = p[AT_active_longest];
    const real slow = p[AT_active_shallow_slope], half_plateau = 0.05, shoulder = 1 - half_plateau;
    const real at_turn = 1 - slow * (shoulder - turn), steep = 1.25 * at_turn / (turn - begin);
    const real fall = -1 / ((end - half_plateau) - (1 + half_plateau));
    set_knot(curve, begin, least, 0);
    set_knot(curve + 3, 0.5 * (begin + turn), 0.5 * at_turn, steep);
    set_knot(curve + 6, 0.5 * (turn + shoulder), 0.5 * (1 + at_turn), slow);
    set_knot(curve + 9, 1, 1, 0);
    set_knot(curve + 12, 0.5 * (1 + half_plateau + end), 0.5, fall);
    set_knot(curve + 15, end, least, 0);
}

static void prepare_velocity(const real *p, real *curve)
{
    const real near = 0.9, least = is_singular(p) ? 0.5 : 0; /* part of the slope near vmax */
    const real shorten_near = p[AT_concentric_slope_near_vmax];
    const real lengthen_near = p[AT_eccentric_slope_near_vmax], most = p[AT_eccentric_force];
    const real shorten = larger(p[AT_concentric_slope_at_vmax], least * shorten_near);
    const real lengthen = larger(p[AT_eccentric_slope_at_vmax], least * lengthen_near);
    set_knot(curve, -1, 0, shorten);
    set_knot(curve + 3, -near, 0.5 * (shorten_near + shorten) * (1 - near), shorten_near);
    set_knot(curve + 6, 0, 1, p[AT_isometric_slope]);
    set_knot(curve + 9, near, most - 0.5 * (lengthen_near + lengthen) * (1 - near), lengthen_near);
    set_knot(curve + 12, 1, most, lengthen);
}

static void prepare_passive(const real *p, real *curve)
{
    const real zero = 1 + p[AT_passive_zero_strain], one = 1 + p[AT_passive_fibre_strain];
    const real steep = value_of(p[AT_passive_stiffness]) > 0 ? p[AT_passive_stiffness] : 2 / (one - zero);
    const real toe = smaller(0.1 / steep, 0.1 * (one - zero)), low = p[AT_passive_stiffness_low];
    set_knot(curve, zero, 0, 0);
    set_knot(curve + 3, zero + toe, low * toe / 2, low);
    set_knot(curve + 6, one, 1, steep);
}

/* A toe of two elbows; the line that follows goes through F0 at its strain. */
static void prepare_tendon(const real *p, real *curve)
{
    const real strain = p[AT_tendon_strain], toe = p[AT_tendon_toe_force];
    const real steep = value_of(p[AT_tendon_stiffness]) > 0 ? p[AT_tendon_stiffness] : 1.375 / strain;
    const real one = 1 + strain, at_toe = (toe - 1) / steep + one, foot = 1 + (at_toe - 1) / 10;
    const real at_half = (toe / 2 - 1) / steep + one, slope = toe / 2 / (at_half - foot);
    set_knot(curve, 1, 0, 0);
    set_knot(curve + 3, foot + 0.5 * (at_half - foot), toe / 4, slope);
    set_knot(curve + 6, at_toe, toe, steep);
}

static void prepare_curves(const real *p, real *k)
{
    const real shortening = p[AT_concentric_curviness], lengthening = p[AT_eccentric_curviness];
    prepare_active(p, k + ACTIVE);
    bezier_prepare(k + ACTIVE, ACTIVE_PIECES, (const real[]){1, 1, 1, 1, 1});
    prepare_velocity(p, k + VELOCITY);
    bezier_prepare(k + VELOCITY, VELOCITY_PIECES,
                   (const real[]){shortening, shortening, lengthening, lengthening});
    prepare_passive(p, k + PASSIVE);
    bezier_prepare(k + PASSIVE, PASSIVE_PIECES,
                   (const real[]){p[AT_passive_curviness], p[AT_passive_curviness]});
    prepare_tendon(p, k + TENDON);
    bezier_prepare(k + TENDON, TENDON_PIECES,
                   (const real[]){p[AT_tendon_curviness], p[AT_tendon_curviness]});
}

static const char *refusal(const real *p)
{
    if (value_of(p[AT_fibre_damping]) < 0) return "fibre_damping must not be negative";
    if (!(value_of(p[AT_maximum_pennation]) > 0 && value_of(p[AT_maximum_pennation]) < 1.571))
        return "maximum_pennation must be between 0 and a right angle";
    const char *wrong = hill_refusal(p);
    if (wrong) return wrong;
    if (value_of(p[AT_pennation_at_optimal]) >= value_of(p[AT_maximum_pennation]))
        return "pennation_at_optimal must be below maximum_pennation";
    const int parts[] = {AT_concentric_curviness, AT_eccentric_curviness, AT_passive_curviness,
                         AT_tendon_curviness, AT_active_minimum};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        if (value_of(p[parts[i]]) < 0 || value_of(p[parts[i]]) > 1)
            return "curvinesses and active_minimum must be from 0 to 1";
    const int natural[] = {AT_active_shortest, AT_active_shallow_slope, AT_concentric_slope_at_vmax,
                           AT_eccentric_slope_at_vmax, AT_passive_stiffness, AT_tendon_stiffness};
    for (size_t i = 0; i < sizeof natural / sizeof *natural; i++)
        if (value_of(p[natural[i]]) < 0) return "lengths, slopes and stiffnesses must not be negative";
    if (value_of(p[AT_passive_stiffness]) > 1e7 || value_of(p[AT_tendon_stiffness]) > 1e7)
        return "passive_stiffness and tendon_stiffness must be 1e7 at most";
    if (value_of(p[AT_concentric_slope_near_vmax]) < value_of(p[AT_concentric_slope_at_vmax]) ||
        value_of(p[AT_eccentric_slope_near_vmax]) < value_of(p[AT_eccentric_slope_at_vmax]))
        return "a slope at vmax must not be above that near vmax";
    if (value_of(p[AT_concentric_slope_near_vmax]) > 1 || value_of(p[AT_eccentric_slope_near_vmax]) > 1)
        return "slopes near vmax must be 1 at most";
    if (!(value_of(p[AT_isometric_slope]) > 1) || !(value_of(p[AT_eccentric_force]) > 1))
        return "isometric_slope and eccentric_force must be above 1";
    if (!(value_of(p[AT_passive_fibre_strain]) > 0) || !(value_of(p[AT_tendon_strain]) > 0) ||
        value_of(p[AT_passive_zero_strain]) < -1)
        return "strains must be positive, passive_zero_strain -1 at least";
    if (!(value_of(p[AT_passive_stiffness_low]) > 0)) return "passive_stiffness_low must be positive";
    if (!(value_of(p[AT_tendon_toe_force]) > 0 && value_of(p[AT_tendon_toe_force]) <= 1))
        return "tendon_toe_force must be above 0, and 1 at most";
    real k[CONSTANTS];
    prepare_curves(p, k);
    if (!bezier_is_sound(k + ACTIVE, ACTIVE_PIECES))
        return "the active force-length curve folds over; see its lengths and slope";
    if (!bezier_is_sound(k + VELOCITY, VELOCITY_PIECES))
        return "the force-velocity curve folds over; see its slopes and eccentric_force";
    if (!bezier_is_sound(k + PASSIVE, PASSIVE_PIECES))
        return "the passive force-length curve folds over; see its strains and stiffnesses";
    if (!bezier_is_sound(k + TENDON, TENDON_PIECES))
        return "the tendon curve folds over; see its strain, stiffness and toe";
    return NULL;
}

static real active(const real *k, real x, real *slope)
{
    return bezier_value(law_shared(k) + ACTIVE, ACTIVE_PIECES, x, slope);
}

static real velocity(const real *k, real x, real *slope)
{
    return bezier_value(law_shared(k) + VELOCITY, VELOCITY_PIECES, x, slope);
}

static real passive(const real *k, real x, real *slope)
{
    return bezier_value(law_shared(k) + PASSIVE, PASSIVE_PIECES, x, slope);
}

static real tendon(const real *k, real x, real *slope)
{
    return bezier_value(law_shared(k) + TENDON, TENDON_PIECES, x, slope);
}

static void prepare(const real *p, real *k)
{
    const real damping = value_of(p[AT_fibre_damping]) < value_of(LEAST_DAMPING) ? 0 : p[AT_fibre_damping];
    hill_prepare(p, p[AT_active_shortest], p[AT_maximum_pennation], damping, 0, k);
    if (is_singular(p)) k[HILL_LEAST_ACTIVATION] = larger(k[HILL_LEAST_ACTIVATION], 0.01);
    prepare_curves(p, k);
}

static real product(const real *k, real z, real w, real *passive)
{
    const real *shared = law_shared(k);
    const bezier_point of[BEZIER_POINTS] = {{shared + ACTIVE, ACTIVE_PIECES, z},
                                            {shared + VELOCITY, VELOCITY_PIECES, w},
                                            {shared + PASSIVE, PASSIVE_PIECES, z}};
    real y[BEZIER_POINTS];
    bezier_values(of, y);
    *passive = y[2];
    return y[0] * y[1];
}

static const hill_curves CURVES = {active, velocity, passive, tendon, NULL, product};
HILL_FUNCTIONS(CURVES)

/* All that curves depend on begins with whether the tendon is elastic. */
const tension_law LAW_MILLARD = HILL_LAW(PARAMETERS, CONSTANTS, AT_elastic_tendon);
