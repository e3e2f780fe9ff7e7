/* Derivatives of the steps of many instances of a robot; see ../batch/batch.h. They only exist if derivatives are
   supported: see support.h. */
#ifndef CARDSFLOW_BATCH_DERIVATIVES_H
#define CARDSFLOW_BATCH_DERIVATIVES_H

#include "../core.h"
#include "support.h"

/* Return the size of memory in bytes that core_batch_derivatives needs. */
CORE_API size_t core_batch_derivatives_size(const core *plain);

/* Compute the derivatives of core_batch_step, count x states x directions, without a step. The state is (q, qd,
   law_states). `inputs` are the directions: indices in (state, commands, external forces). */
CORE_API void core_batch_derivatives(const void *memory, size_t stride, int32_t count, void *scratch, const double *u,
                                     const double *extra, double h, int32_t steps, int32_t is_runge_kutta,
                                     int32_t directions, const int32_t *inputs, double *derivatives, int32_t *answers);

#endif
