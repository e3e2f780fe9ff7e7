/* A robot with loops in the independent coordinates, for its control law. */
#ifndef NATIVE_INDEPENDENT_TERMS_H
#define NATIVE_INDEPENDENT_TERMS_H

#include "state.h"

/* Set whether the robot has dependent coordinates, and initialize `undetermined`. */
void native_independent_open(struct controller *c, const struct native_robot *robot);

/* Compute M, h and L of qdd = N qdd + c at the last q of the core: N'M N with 1 for dependent coordinates,
   N'(h + M c), L N. */
void native_independent_terms(struct controller *c, const struct native_robot *robot, const double *qd, double *M,
                              double *h, double *L);
/* Compute J N and J' qd + J c. */
void native_independent_tasks(struct controller *c, const struct native_robot *robot, const double *qd, double *J,
                              double *bias);
/* Compute N' G; call native_independent_terms first. */
void native_independent_gravity(const struct controller *c, const struct native_robot *robot, double *G);
/* Compute N' load. */
void native_independent_load(struct controller *c, const struct native_robot *robot, const double *q,
                             const double *qd, double *load);
/* Compute the accelerations of all coordinates, N qdd + c. */
void native_independent_complete(struct controller *c, const struct native_robot *robot, const double *q,
                                 const double *qd, double *qdd);

#endif
