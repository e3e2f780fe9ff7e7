/* Derivatives of the rates of the state: of qd, qdd and law_rates by q, qd, law_states, commands and external
   generalised forces. Limits and friction of joints are not included, and cables have no friction.

   Complex numbers are used only for the change of the paths and of the tree along each coordinate, and for
   each muscle law by its own numbers: length, rate, command and states. Tensions act by -M^-1 L'. */
#ifndef CARDSFLOW_RATE_JACOBIAN_H
#define CARDSFLOW_RATE_JACOBIAN_H

#include "../core.h"
#include "support.h"
#include "tangent.h"

typedef struct rate_jacobian rate_jacobian;

/* Return the size of memory in bytes for a robot. */
size_t rate_jacobian_size(const core *plain);

/* Create a handle in `memory`, which is 8-byte aligned; see core_tangent_open. The plain handle must outlive
   it. */
rate_jacobian *rate_jacobian_open(core *plain, void *memory);

/* Return its robot with tangents. Between two uses of this handle, the robot itself must be without changes. */
core_tangent *rate_jacobian_tangent(const rate_jacobian *r);

/* Compute the derivatives at the last state_rates_evaluate of the plain handle, with the same commands and
   external forces; rows: q, qd, law_states; columns: the same, commands, external forces. */
const double *rate_jacobian_fill(rate_jacobian *r, const double *commands, const double *torques);

/* Compute the derivatives of q and qd after loops_close by q and qd before it, 2 dofs x 2 dofs, at the state
   of the plain handle. */
const double *rate_jacobian_close(rate_jacobian *r);

#endif
