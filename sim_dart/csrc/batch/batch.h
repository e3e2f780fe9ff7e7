/* Many instances of a robot: handles of core_open that lie `stride` bytes apart, the first one at `memory`.

   Each function computes the `count` instances in order, one after another, with the functions of core.h.
   So results do not depend on how a caller distributes instances over threads. All robots have the same
   numbers of coordinates, muscles, states and so on. `answers`, one per instance: 0, or the nonzero return
   value of the call that failed; instances with a nonzero answer are left unchanged. */
#ifndef CARDSFLOW_BATCH_H
#define CARDSFLOW_BATCH_H

#include "../core.h"

/* Terms that core_batch_terms computes; see core_array. */
enum batch_term {
    BATCH_MASS_MATRIX = 1,
    BATCH_BIAS = 2, /* C + G in `coriolis` */
    BATCH_TASK_JACOBIAN = 4,
    BATCH_TENSIONS = 8 /* also rates and torques */
};

/* Return the size of the working memory `group`, with which instances of the robot are computed in the lanes of
   vectors; 0 if lanes do not support it, see lanes.h. */
CORE_API size_t core_batch_group_size(const core *c);

/* Do the same as core_step, or core_runge_kutta, with the commands u, count x muscles, and the external
   generalised forces, count x dofs, or NULL, for instances with a nonzero `chosen`, or for all if it is NULL.
   `group`: see above; zero before the first call; NULL without lanes. Results are the same with and without lanes. */
CORE_API void core_batch_step(void *memory, size_t stride, int32_t count, const uint8_t *chosen, const real *u,
                              const real *extra, real h, int32_t steps, int32_t is_runge_kutta, void *group,
                              int32_t *answers);

/* Set q and qd, count x dofs, of instances with a nonzero `chosen`, or the nearest state with closed loops;
   and the states of the muscles to the equilibrium with the commands u, count x muscles, or to 0 if u is NULL.
   Their answers become 0; 1 + the index of a coordinate whose value is invalid; or -1 - the index of a closure
   that stays open. */
CORE_API void core_batch_reset(void *memory, size_t stride, int32_t count, const uint8_t *chosen, const real *q,
                               const real *qd, const real *u, int32_t *answers);

/* Compute the terms in `which`, a sum of enum batch_term, at the current states; u as for core_batch_step. */
CORE_API void core_batch_terms(void *memory, size_t stride, int32_t count, int32_t which, const real *u);

#endif
