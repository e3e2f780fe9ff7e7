#if !defined(_WIN32) && !defined(_GNU_SOURCE)
#define _POSIX_C_SOURCE 200809L /* strict compilers need it for clock_gettime */
#endif
#include "master.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

struct copy {
    const double *from;
    double *to;
    int32_t form;
    double factor, offset;
};

struct turn {
    master_step *step;
    void *instance;
    int32_t every, stage, first, before, after; /* copies */
};

struct column {
    const double *value;
    double limit;
};

struct master {
    int32_t turns_count, copies_count, columns_count, before, timed;
    double step;
    const double *timer;
    struct turn *turns;
    struct copy *copies;
    struct column *columns;
};

static void *room(int32_t count, size_t size)
{
    return calloc((size_t)count + 1, size);
}

struct master *master_open(int32_t turns, int32_t copies, int32_t columns)
{
    struct master *master = calloc(1, sizeof *master);
    if (!master)
        return NULL;
    master->timed = -1;
    master->turns = room(turns, sizeof *master->turns);
    master->copies = room(copies, sizeof *master->copies);
    master->columns = room(columns, sizeof *master->columns);
    if (master->turns && master->copies && master->columns)
        return master;
    master_close(master);
    return NULL;
}

void master_close(struct master *master)
{
    free(master->turns);
    free(master->copies);
    free(master->columns);
    free(master);
}

/* --------------------------------------------------------------------------------------- the plan */

void master_add_turn(struct master *master, master_step *step, void *instance, int32_t every, int32_t stage)
{
    struct turn *turn = &master->turns[master->turns_count++];
    turn->step = step;
    turn->instance = instance;
    turn->every = every;
    turn->stage = stage;
    turn->first = master->copies_count;
}

void master_add_copy(struct master *master, int32_t is_after, const double *from, double *to, int32_t form,
                     double factor, double offset)
{
    const struct copy copy = {from, to, form, factor, offset};
    struct turn *turn = &master->turns[master->turns_count - 1];
    master->copies[master->copies_count++] = copy;
    ++*(is_after ? &turn->after : &turn->before);
}

void master_add_column(struct master *master, const double *value, double limit)
{
    const struct column column = {value, limit};
    master->columns[master->columns_count++] = column;
}

void master_set_step(struct master *master, double step, int32_t before)
{
    master->step = step;
    master->before = before;
}

void master_set_timer(struct master *master, int32_t turn, const double *value)
{
    master->timed = turn;
    master->timer = value;
}

/* -------------------------------------------------------------------------------------- the steps */

static void run_copies(const struct copy *copy, int32_t count)
{
    for (const struct copy *end = copy + count; copy < end; copy++) {
        const double value = *copy->from;
        if (copy->form == COPY_EXACT)
            *copy->to = value;
        else if (copy->form == COPY_SCALED)
            *copy->to = copy->factor * value + copy->offset;
        else
            *copy->to = (value - copy->offset) / copy->factor;
    }
}

struct call {
    int64_t k; /* number of the step */
    double *times;
    struct master_progress *progress;
    int is_paused;
};

/* Run the turns of one stage, from `turn` on: set the inputs of all of them, then step them. `turn` advances to
 * the next stage. Return nonzero if a participant failed. */
static int run_stage(const struct master *master, int32_t *turn, struct call *call)
{
    const struct turn *first = master->turns + *turn, *end = master->turns + master->turns_count;
    const struct turn *next = first;
    for (; next < end && next->stage == first->stage; next++)
        if (call->k % next->every == 0)
            run_copies(master->copies + next->first, next->before);
    *turn = (int32_t)(next - master->turns);
    for (const struct turn *entry = first; entry < next; entry++) {
        if (call->k % entry->every)
            continue;
        const int code = entry->step(entry->instance, (double)call->k * master->step, entry->every * master->step);
        if (code && code != MASTER_PAUSE) {
            call->progress->turn = (int32_t)(entry - master->turns);
            call->progress->code = code;
            return 1;
        }
        call->is_paused |= code == MASTER_PAUSE;
        run_copies(master->copies + entry->first + entry->before, entry->after);
        if (entry - master->turns == master->timed) {
            if (master->timer)
                call->times[call->progress->ticks] = *master->timer;
            call->progress->ticks++;
        }
    }
    return 0;
}

static int is_good(const struct master *master, const double *row)
{
    for (int32_t i = 0; i < master->columns_count; i++)
        if (!(fabs(row[1 + i]) <= master->columns[i].limit))
            return 0;
    return 1;
}

static void record(const struct master *master, double time, double *row)
{
    row[0] = time;
    for (int32_t i = 0; i < master->columns_count; i++)
        row[1 + i] = *master->columns[i].value;
}

int master_record(const struct master *master, double time, double *row)
{
    record(master, time, row);
    return is_good(master, row) ? MASTER_RAN : MASTER_BAD_ROW;
}

/* The row is checked at the end of the step, so that a failure in the same step is reported, too. */
static int run_step(const struct master *master, double *row, struct call *call)
{
    int32_t turn = 0;
    while (turn < master->turns_count && master->turns[turn].stage < master->before)
        if (run_stage(master, &turn, call))
            return MASTER_FAILED;
    record(master, (double)call->k * master->step, row);
    call->progress->rows++;
    while (turn < master->turns_count)
        if (run_stage(master, &turn, call))
            return MASTER_FAILED;
    call->progress->done++;
    return is_good(master, row) ? MASTER_RAN : MASTER_BAD_ROW;
}

static double now(void)
{
#if defined(_WIN32)
    return (double)clock() / CLOCKS_PER_SEC; /* elapsed time, not processor time */
#else
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
#endif
}

int master_run(struct master *master, int64_t first, int64_t count, double seconds, double *rows, double *times,
               struct master_progress *progress)
{
    const struct master_progress none = {0, 0, 0, 0, 0};
    const double end = now() + seconds;
    const int64_t width = 1 + (int64_t)master->columns_count;
    struct call call = {first, times, progress, 0};
    *progress = none;
    for (; call.k < first + count; call.k++) {
        const int ended = run_step(master, rows + width * (call.k - first), &call);
        if (ended || call.is_paused || now() >= end)
            return ended;
    }
    return MASTER_RAN;
}
