/* The exact transition matrix of a step, for estimators. */
#ifndef CARDSFLOW_TRANSITION_H
#define CARDSFLOW_TRANSITION_H

#include "../core.h"
#include "support.h"

typedef struct core_transition core_transition;

/* Return the size of memory in bytes for a robot; 0 if derivatives are not supported: see support.h. */
CORE_API size_t core_transition_size(const core *plain);

/* Create a handle in `memory`, which is 8-byte aligned; see core_tangent_open. The plain handle must outlive
   it, since the states of its bends are used. Return NULL if derivatives are not supported. */
CORE_API core_transition *core_transition_open(const core *plain, void *memory);

/* An estimator_transition; `self` is a core_transition. If derivatives are not supported, return nonzero. */
CORE_API int core_transition_fill(void *self, const real *q, const real *qd, const real *f, const real *extra, real h,
                                  real *A);

#endif
