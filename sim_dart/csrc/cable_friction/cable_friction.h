/* Friction of cables in their bends. */
#ifndef CARDSFLOW_CABLE_FRICTION_H
#define CARDSFLOW_CABLE_FRICTION_H

#include "../blob/state.h"

/* Add to `torques` what friction does to tensions that act without it: bend_tension, far_tensions. */
CORE_INSIDE void cable_friction_pull(core *c);

/* Before the velocities of a step are sought: torques for the first round. */
CORE_INSIDE void cable_friction_begin(core *c, real h);
/* Whether velocities found with the last torques agree with friction; if so, torques are what acts. If not,
   torques are for the next round.                                                                      */
CORE_INSIDE int cable_friction_agrees(core *c, real h);
/* Add to M, dofs x dofs, what friction resists within a step. */
CORE_INSIDE void cable_friction_resist(const core *c, real *M);

/* How fast cables slide in their bends at velocities qd; what that does to the bends' states: their time
   derivatives, and after a time h. */
CORE_INSIDE void cable_friction_rates(core *c, const real *qd);
CORE_INSIDE void cable_friction_state_rates(core *c);
CORE_INSIDE void cable_friction_advance(core *c, real h);
/* Neither way. */
CORE_INSIDE void cable_friction_start(core *c);

#endif
