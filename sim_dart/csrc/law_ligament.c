/* ligament_blankevoort1991: a toe, f = k e^2 / (2 e_t), then a line, f = k (e - e_t / 2); e is the strain.
   Damping c e' acts while it is taut and lengthens, in full from a strain of 0.01: up to there it sets in
   smoothly, as in OpenSim, so that the force is continuous.

   Blankevoort, Kuiper, Huiskes & Grootenboer 1991, J. Biomech. 24: Articular contact in a
   three-dimensional model of the knee.                                                                */
#include "law.h"

#include <stddef.h>

enum { LIGAMENT_PARAMETERS(AT) PARAMETERS };
enum { STIFFNESS = LAW_OWN, TOE, DAMPING, SLACK_LENGTH, CONSTANTS };

static const real FULL_DAMPING = 0.01;

static const char *refusal(const real *p)
{
    if (value_of(p[AT_linear_stiffness]) < 0) return "linear_stiffness must not be negative";
    if (!(value_of(p[AT_transition_strain]) > 0)) return "transition_strain must be positive";
    if (value_of(p[AT_damping_coefficient]) < 0) return "damping_coefficient must not be negative";
    return value_of(p[AT_slack_length]) > 0 ? NULL : "slack_length must be positive";
}

static void prepare(const real *p, real *k)
{
    k[LAW_LOW] = k[LAW_HIGH] = 0;
    k[STIFFNESS] = p[AT_linear_stiffness], k[TOE] = p[AT_transition_strain];
    k[DAMPING] = p[AT_damping_coefficient], k[SLACK_LENGTH] = p[AT_slack_length];
}

/* From 0 to 1 with two derivatives. */
static real onset(real strain)
{
    const real x = strain / FULL_DAMPING;
    return value_of(x) < 1 ? x * x * x * (10 + x * (6 * x - 15)) : 1;
}

static real tension(const real *k, const real *x, real l, real v, real u)
{
    (void)x, (void)u;
    const real strain = l / k[SLACK_LENGTH] - 1, toe = k[TOE];
    if (value_of(strain) <= 0) return 0;
    const real spring = value_of(strain) < value_of(toe) ? k[STIFFNESS] * strain * strain / (2 * toe)
                                       : k[STIFFNESS] * (strain - toe / 2);
    return value_of(v) > 0 ? spring + onset(strain) * k[DAMPING] * v / k[SLACK_LENGTH] : spring;
}

const tension_law LAW_LIGAMENT = {
    .parameters = PARAMETERS,
    .constants = CONSTANTS,
    .refusal = refusal,
    .prepare = prepare,
    .tension = tension,
};
