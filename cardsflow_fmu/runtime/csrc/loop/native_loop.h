/* A closed loop of native models in a browser: tables of numbers for the co-simulation master, which steps the
 * models; see cosim/csrc/master.h. loop_tables.py creates the tables:
 *
 *     turns    model, number of base steps per step, number of its copies, number of its stage; in the
 *              order in which the models are stepped
 *     copies   source model, index of its value, target model, index there; turn after turn
 *     changes  factor and offset of the value of each copy
 *     columns  model and index of each recorded value, after the time
 *
 * A model is identified by its number. Every loop must be called from one thread at a time. */
#ifndef NATIVE_LOOP_H
#define NATIVE_LOOP_H

#include "opened_model.h"

struct native_loop;

/* Create a loop of open models, which must outlive it. Return NULL if memory is insufficient. */
NATIVE_API struct native_loop *native_loop_open(int32_t count, struct opened_model *const *models);
NATIVE_API void native_loop_close(struct native_loop *loop);

/* Set the tables, once. Return 0, or nonzero if a number in them is invalid. The first `before` stages are
 * computed before a step is recorded, the others after it. `timer` is the model and the index of a value
 * that is recorded at every tick; or -1, -1. */
NATIVE_API int native_loop_plan(struct native_loop *loop, int32_t turns_count, const int32_t *turns,
                                int32_t copies_count, const int32_t *copies, const double *changes,
                                int32_t columns_count, const int32_t *columns, int32_t before,
                                const int32_t *timer);

/* Run the steps `first` to `first + count - 1`, each of `step` s. Each step writes a row of 1 + columns
 * values into `rows`, and each tick a time into `times`. `done` is the number of completed steps, and of
 * written rows. Return 0, or 1 + the model that failed. */
NATIVE_API int native_loop_run(struct native_loop *loop, double step, int64_t first, int64_t count,
                               double *rows, double *times, int64_t done[2]);

#endif
