/* ligament_blankevoort1991: a toe, f = k e^2 / (2 e_t), then a straight line, f = k (e - e_t / 2); e is the
   strain. Damping c e' acts while the ligament is taut and lengthens. It grows smoothly up to a strain of
   0.01, as in OpenSim, so that the force is continuous.

   Blankevoort, Kuiper, Huiskes & Grootenboer 1991, J. Biomech. 24: Articular contact in a three-dimensional
   model of the knee. */
#include "../math/quintic_step.h"
#include "law.h"

enum {
    LIGAMENT_STIFFNESS = LAW_OWN,
    LIGAMENT_TOE,
    LIGAMENT_DAMPING,
    LIGAMENT_SLACK_LENGTH,
    LIGAMENT_CONSTANTS
};

static const real FULL_DAMPING = 0.01;

static void ligament_prepare(const void *parameters, real *k)
{
    const ligament_blankevoort1991_parameters *p = parameters;
    k[LIGAMENT_STIFFNESS] = p->linear_stiffness, k[LIGAMENT_TOE] = p->transition_strain;
    k[LIGAMENT_DAMPING] = p->damping_coefficient, k[LIGAMENT_SLACK_LENGTH] = p->slack_length;
}

static real onset(real strain)
{
    const real x = strain / FULL_DAMPING;
    return value_of(x) < 1 ? quintic_step(x) : 1;
}

static real ligament_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)x, (void)u;
    const real strain = l / k[LIGAMENT_SLACK_LENGTH] - 1, toe = k[LIGAMENT_TOE];
    if (value_of(strain) <= 0) return 0;
    const real spring = value_of(strain) < value_of(toe) ? k[LIGAMENT_STIFFNESS] * strain * strain / (2 * toe)
                                       : k[LIGAMENT_STIFFNESS] * (strain - toe / 2);
    return value_of(v) > 0 ? spring + onset(strain) * k[LIGAMENT_DAMPING] * v / k[LIGAMENT_SLACK_LENGTH]
                           : spring;
}

TENSION_LAW(ligament_blankevoort1991) = {
    .constants = LIGAMENT_CONSTANTS,
    .prepare = ligament_prepare,
    .tension = ligament_tension,
};
