/* Model predictive control in a native controller; see controllers/csrc/mpc/mpc.h. All functions have no effect
 * for other laws. */
#ifndef NATIVE_PREDICTIVE_H
#define NATIVE_PREDICTIVE_H

#include "state.h"

/* Open the law, if the settings contain it, and use it in the loop. `tasks` is the one of the loop's
 * control_robot. Return 0, or nonzero with a message; must be closed in either case. */
int native_predictive_open(struct controller *c, struct native_model *native,
                           void (*tasks)(void *, const double *, const double *, const double *, double *, double *,
                                         double *),
                           struct text *error);
void native_predictive_close(struct controller *c);

void native_predictive_reset(const struct controller *c);

/* Set the time in s and the bounds for the next tick. */
void native_predictive_set(struct controller *c, double time, double period);

/* Write whether the last tick used the computed-torque law, its number of iterations, and whether the deadline
 * ended them. */
void native_predictive_report(const struct controller *c, double *report);

/* Return the internal state and its length, which may be 0. */
double *native_predictive_memory(const struct controller *c, size_t *length);

/* Return the array "mpc.<name>" and its length; NULL if it does not exist. */
double *native_predictive_array(const struct controller *c, const char *name, size_t *length);

#endif
