/* Friction of cables in their bends. */
#ifndef CARDSFLOW_CABLE_FRICTION_H
#define CARDSFLOW_CABLE_FRICTION_H

#include "../blob/state.h"

/* Add to `torques` the effect of friction; compute bend_tension and far_tensions. Tensions must be those
   without friction. */
CORE_INSIDE void cable_friction_pull(core *c);

/* Prepare the computation of the velocities of a step: torques for the first iteration. */
CORE_INSIDE void cable_friction_begin(core *c, real h);
/* Return whether the velocities found with the last torques agree with friction. If they do, torques are the
   acting ones. Otherwise compute the torques for the next iteration. */
CORE_INSIDE int cable_friction_has_converged(core *c, real h);
/* Add to M, dofs x dofs, the resistance of friction within a step. */
CORE_INSIDE void cable_friction_resist(const core *c, real *M);

/* Compute the sliding velocities in the bends at velocities qd; the time derivatives of the states of the
   bends; their states after a time h. */
CORE_INSIDE void cable_friction_rates(core *c, const real *qd);
CORE_INSIDE void cable_friction_state_rates(core *c);
CORE_INSIDE void cable_friction_advance(core *c, real h);
/* Set the friction of all bends to zero. */
CORE_INSIDE void cable_friction_start(core *c);

#endif
