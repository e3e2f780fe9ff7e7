/* A closed loop of native models in a browser: tables of numbers for the co-simulation master, which steps the
 * models; see cosim/csrc/master.h. loop_tables.py creates the tables:
 *
 *     turns    model, number of base steps per step, number of its copies, number of its stage; in the
 *              order in which the models are stepped
 *     copies   source model, index of its value, target model, index there; turn after turn
 *     changes  factor and offset of the value of each copy
 *
 * A model is identified by its number. Every loop must be called from one thread at a time. */
#ifndef NATIVE_LOOP_H
#define NATIVE_LOOP_H

#include "opened_model.h"

struct native_loop;

/* Create a loop of open models, which must outlive it. Return NULL if memory is insufficient. */
NATIVE_API struct native_loop *native_loop_open(int32_t count, struct opened_model *const *models);
NATIVE_API void native_loop_close(struct native_loop *loop);

/* Set the tables, once. Return 0, or nonzero if a number in them is invalid. */
NATIVE_API int native_loop_plan(struct native_loop *loop, int32_t turns_count, const int32_t *turns,
                                int32_t copies_count, const int32_t *copies, const double *changes);

enum { NATIVE_LOOP_STEPS = 64 };

/* Run the steps `first` to `first + count - 1`, at most NATIVE_LOOP_STEPS, each of `step` s. `done` is the number
 * of completed steps. Return 0, or 1 + the model that failed. */
NATIVE_API int native_loop_run(struct native_loop *loop, double step, int64_t first, int64_t count,
                               int64_t *done);

#endif
