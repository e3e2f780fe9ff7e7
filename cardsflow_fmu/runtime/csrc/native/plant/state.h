/* The inside of a native plant.
 *
 * Values: commands (c), loads (3 p), wrenches (6 k); q (n), qd (n), l (m), y, tensions (t), states (s), energies
 * and momenta (11 or none); start q (n), start qd (n), step, worker_timeout. */
#ifndef NATIVE_PLANT_STATE_H
#define NATIVE_PLANT_STATE_H

#include "../model.h"

#include <stddef.h>
#include <stdint.h>

enum { ENERGY_OUTPUTS = 11 }; /* energies 2, work 3, momentum 3, angular momentum 3 */

/* A rule of the core: core_step or core_runge_kutta. */
typedef int plant_rule(core *c, const double *u, const double *extra, double h, int32_t steps);

struct plant {
    double ticks, substeps;
    plant_rule *rule;
    size_t c, t, s, k;
    const double *commanded, *modelled, *order;
    size_t energy_count; /* 0 where there are no outputs of energy */
    double standing; /* potential energy of what does not move */
    double work[3];  /* since the start; see core.h */
    double *muscle_commands; /* m: of passive muscles 0 */
    int32_t *frames; /* p + k: of the points of external wrenches */
    double *external_wrenches; /* 6 a point: see core_external_wrenches */
    double *commands, *loads, *wrenches, *q, *qd, *lengths, *tasks, *tensions, *states, *energies;
    double *q_start, *qd_start, *step;
    struct core_tangent *tangent; /* from the first question for a derivative on */
};

#endif
