/* The fixed-step loop of a co-simulation; cosim/stepper.py uses it.
 *
 * A turn is a participant in the order of a step. Turns of the same stage receive their inputs before any of
 * them steps. Participants are functions with an instance: native models, FMUs (fmu_step.h), or callbacks into
 * Python. The pointers of turns, copies and columns must outlive the master. Every master must be called from
 * one thread at a time. */
#ifndef MASTER_H
#define MASTER_H

#include "export.h"

#include <stdint.h>

/* Advance from t to t + h, in s. Return 0; MASTER_PAUSE to end master_run after the current step; or another
 * number, which is a failure. */
typedef int master_step(void *instance, double t, double h);

enum { MASTER_PAUSE = -1 };

enum copy_form {
    COPY_EXACT,   /* value; preserves a negative zero */
    COPY_SCALED,  /* factor * value + offset */
    COPY_UNSCALED /* (value - offset) / factor */
};

enum master_end {
    MASTER_RAN,      /* all steps are complete, the time is over, or a participant requested a pause */
    MASTER_FAILED,   /* a participant failed; the step is not complete */
    MASTER_BAD_ROW   /* the last row has a value beyond its limit, or a value that is not finite */
};

struct master_progress {
    int64_t done;  /* completed steps */
    int64_t rows;  /* recorded rows */
    int64_t ticks; /* completed steps of the timed participant */
    int32_t turn;  /* of the participant that failed */
    int32_t code;  /* its result */
};

struct master;

/* Create a master with room for turns, copies and columns. Return NULL if memory is insufficient. */
RUN_API struct master *master_open(int32_t turns, int32_t copies, int32_t columns);
RUN_API void master_close(struct master *master);

/* Add the next turn, in the order in which participants step. It steps every `every`-th step. Stages start at 0
 * and do not decrease. The copies that follow belong to this turn. */
RUN_API void master_add_turn(struct master *master, master_step *step, void *instance, int32_t every,
                             int32_t stage);
/* Add a copy before the step of the last turn (`is_after` is 0), or after it. All copies before the step must be
 * added first. */
RUN_API void master_add_copy(struct master *master, int32_t is_after, const double *from, double *to,
                             int32_t form, double factor, double offset);
/* Add a recorded value. Its absolute value must not exceed `limit`. */
RUN_API void master_add_column(struct master *master, const double *value, double limit);

/* Set the communication step, in s, and the number of stages that step before a row is recorded. */
RUN_API void master_set_step(struct master *master, double step, int32_t before);
/* Set the turn whose steps are counted as ticks, and the value that is recorded at each tick, or NULL. */
RUN_API void master_set_timer(struct master *master, int32_t turn, const double *value);

/* Run the steps `first` to `first + count - 1`, or fewer: no step starts `seconds` after the call. Each step
 * writes a row of 1 + columns values into `rows`, and each tick a value into `times`. */
RUN_API int master_run(struct master *master, int64_t first, int64_t count, double seconds, double *rows,
                       double *times, struct master_progress *progress);

/* Write a row with the current values. Return MASTER_RAN or MASTER_BAD_ROW. */
RUN_API int master_record(const struct master *master, double time, double *row);

#endif
