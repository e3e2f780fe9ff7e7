/* Internal state of a native plant. */
#ifndef NATIVE_PLANT_STATE_H
#define NATIVE_PLANT_STATE_H

#include "../model.h"

#include <stddef.h>
#include <stdint.h>

enum { ENERGIES = 12, WORKS = 4 }; /* outputs: energies 2, work 4, momentum 3, angular momentum 3 */

/* An integrator: core_step or core_runge_kutta. */
typedef int plant_integrator(core *c, const double *u, const double *extra, double h, int32_t steps);

#define VALUES_MEMBER(name, length) double *name;
struct plant {
    struct plant_settings settings;
    PLANT_GROUPS(VALUES_MEMBER) /* the values of each group */
    plant_integrator *rule;
    double ticks;
    double work[WORKS];           /* since the start; see core.h */
    double *muscle_commands;   /* m: 0 for passive muscles */
    double *external_wrenches; /* 6 per point: see core_external_wrenches */
    double *motor_torques;     /* n: torques of motors at joints */
    /* in model exchange: of the core, see core.h; and q, qd before an event */
    double *tension_scale; /* of the core: 0 for broken cables */
    double *held, *hold_force, *qdd, *state_rates, *before_event;
    struct core_tangent *tangent; /* created at the first request for derivatives */
};
#undef VALUES_MEMBER

/* Return whether the plant is a model in continuous time, for model exchange. */
static inline int plant_is_continuous(const struct plant *plant)
{
    return plant->settings.of.derivatives.count > 0;
}

#endif
