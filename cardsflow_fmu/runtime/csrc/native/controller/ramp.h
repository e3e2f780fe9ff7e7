/* Commands of a native controller whose state may get lost: f = f_rest + s (f_law - f_rest). While it is lost,
 * f_law stays the last one and s falls from 1 to 0 within ramp_down; once it is back, s rises within ramp_in. */
#ifndef NATIVE_RAMP_H
#define NATIVE_RAMP_H

#include "state.h"

/* Numbers that it remembers: the share, the law's last forces, the last positions. */
size_t native_ramp_memory(const struct controller *c);

/* 0, or nonzero where memory lacks. */
int native_ramp_open(struct controller *c);
void native_ramp_reset(struct controller *c, const double *forces);

/* Whether the state is lost. */
int native_ramp_is_due(const struct controller *c);

/* Forces of a tick without a state, in `forces`; the loop has forgotten what it knew, and acts with them. */
void native_ramp_down(struct controller *c, double period);

/* Less of what acts while a lost state has not been back for long. */
void native_ramp_up(struct controller *c, double period);

#endif
