/* Commands of a native controller whose state may get lost: f = f_rest + s (f_law - f_rest). While the state
 * is lost, f_law is constant and s decreases from 1 to 0 within ramp_down. When it returns, s increases
 * within ramp_in. */
#ifndef NATIVE_RAMP_H
#define NATIVE_RAMP_H

#include "state.h"

/* Return the number of values of the internal state: s, the last forces of the law, the last positions. */
size_t native_ramp_memory(const struct controller *c);

/* Return 0, or nonzero if memory is insufficient. */
int native_ramp_open(struct controller *c);
void native_ramp_reset(struct controller *c, const double *forces);

/* Return whether the state is lost. */
int native_ramp_is_due(const struct controller *c);

/* Compute the forces of a tick without a state, in `forces`; the loop is reset, and applies them. */
void native_ramp_down(struct controller *c, double period);

/* Reduce the applied forces during ramp_in after a lost state has returned. */
void native_ramp_up(struct controller *c, double period);

#endif
