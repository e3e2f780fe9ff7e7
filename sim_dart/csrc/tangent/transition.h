/* The exact transition matrix of a step, for estimators. */
#ifndef CARDSFLOW_TRANSITION_H
#define CARDSFLOW_TRANSITION_H

#include "../core.h"
#include "support.h"

typedef struct core_transition core_transition;

/* Bytes of memory for a robot; 0 if there are no derivatives: see support.h. */
CORE_API size_t core_transition_size(const core *plain);

/* A handle in `memory`, 8-byte aligned; see core_tangent_open. The plain one, whose states of bends count, must
   outlive it. NULL if there are no derivatives.                                                     */
CORE_API core_transition *core_transition_open(const core *plain, void *memory);

/* An estimator_transition, of a core_transition; also if there are none, of which it is nonzero. */
CORE_API int core_transition_fill(void *self, const real *q, const real *qd, const real *f, const real *extra, real h,
                                  real *A);

#endif
