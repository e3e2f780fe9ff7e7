/* A robot with loops as its control law knows it: by the coordinates that the others follow from. */
#ifndef NATIVE_INDEPENDENT_TERMS_H
#define NATIVE_INDEPENDENT_TERMS_H

#include "state.h"

/* Whether it has such coordinates; `undetermined` counts from here on. */
void native_independent_open(struct controller *c, const struct native_robot *robot);

/* M, h and L of qdd = N qdd + c at the core's last q: N'M N with 1 for the dependent, N'(h + M c), L N. */
void native_independent_terms(struct controller *c, const struct native_robot *robot, const double *qd, double *M,
                              double *h, double *L);
/* Likewise J N and J' qd + J c. */
void native_independent_tasks(struct controller *c, const struct native_robot *robot, const double *qd, double *J,
                              double *bias);
/* N' G, where the terms have just been asked for. */
void native_independent_gravity(const struct controller *c, const struct native_robot *robot, double *G);
/* N' load. */
void native_independent_load(struct controller *c, const struct native_robot *robot, const double *q,
                             const double *qd, double *load);
/* The accelerations of all coordinates, N qdd + c. */
void native_independent_complete(struct controller *c, const struct native_robot *robot, const double *q,
                                 const double *qd, double *qdd);

#endif
