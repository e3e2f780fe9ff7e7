/* A closed loop of native models, stepped in C: what native_loop.py drives.
 *
 * The loop is the master's: participants in stages, each given outputs of the others before it steps. Its
 * tables are the caller's and stay where they are for as long as the loop is used:
 *
 *     turns    model, every how many steps it is stepped, number of its copies, number of its stage; in the
 *              order in which they are stepped
 *     copies   source model, index of its value, target model, index there; turn after turn
 *     changes  factor and offset of each copy's value
 *     columns  model and index of each value that is recorded, behind the time
 *
 * A model is its number. Every loop must be called from one thread at a time. */
#ifndef NATIVE_LOOP_H
#define NATIVE_LOOP_H

#include "opened_model.h"

struct native_loop;

/* A loop of opened models, which must outlive it. NULL without memory. */
NATIVE_API struct native_loop *native_loop_open(int32_t count, struct opened_model *const *models);
NATIVE_API void native_loop_close(struct native_loop *loop);

/* Takes the tables: 0; or nonzero if a number in them is none that there is. `before` stages come before a
 * step is recorded, the others behind it. `timer` is the model and the index of a value of which every
 * tick's is kept; or -1, -1. */
NATIVE_API int native_loop_plan(struct native_loop *loop, int32_t turns_count, const int32_t *turns,
                                int32_t copies_count, const int32_t *copies, const double *changes,
                                int32_t columns_count, const int32_t *columns, int32_t before,
                                const int32_t *timer);

/* Initialises the models, from the last one on. 0; or 1 + the model that cannot be. */
NATIVE_API int native_loop_initialize(struct native_loop *loop);

/* Steps number `first` to `first + count - 1`, each of `step` s: a row of `rows`, which hold 1 + columns
 * numbers each, and a time of `times` for every one. 0; or 1 + the model that failed. `done` are the steps
 * that are complete, and the rows that are written. */
NATIVE_API int native_loop_run(struct native_loop *loop, double step, int64_t first, int64_t count,
                                    double *rows, double *times, int64_t done[2]);

/* A row as things stand. */
NATIVE_API void native_loop_record(const struct native_loop *loop, double time, double *row);

#endif
