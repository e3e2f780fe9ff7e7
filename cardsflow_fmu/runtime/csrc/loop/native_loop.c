#include "native_loop.h"

#include <stdlib.h>
#include <string.h>

struct native_loop {
    int32_t count, turns_count, columns_count, before;
    const int32_t *turns, *copies, *columns, *timer;
    const double *changes;
    struct opened_model *models[]; /* `count` models */
};

enum { MODEL, EVERY, COPIES, STAGE, TURN }; /* columns of a turn */
enum { SOURCE, FROM, TARGET, TO, COPY };    /* columns of a copy */

struct native_loop *native_loop_open(int32_t count, struct opened_model *const *models)
{
    struct native_loop *loop = calloc(1, sizeof *loop + (size_t)count * sizeof loop->models[0]);
    if (!loop)
        return NULL;
    loop->count = count;
    memcpy(loop->models, models, (size_t)count * sizeof loop->models[0]);
    return loop;
}

void native_loop_close(struct native_loop *loop)
{
    free(loop);
}

/* --------------------------------------------------------------------------------------- the plan */

static int is_value(const struct native_loop *loop, int32_t model, int32_t index)
{
    return model >= 0 && model < loop->count && index >= 0 &&
           (size_t)index < loop->models[model]->ports.count;
}

static int turns_are_sound(const struct native_loop *loop, int32_t count, const int32_t *turns, int32_t copies)
{
    int64_t sum = 0;
    for (int32_t i = 0; i < count; i++, turns += TURN) {
        if (turns[MODEL] < 0 || turns[MODEL] >= loop->count || turns[EVERY] < 1 || turns[COPIES] < 0 ||
            turns[STAGE] < (i ? turns[STAGE - TURN] : 0))
            return 0;
        sum += turns[COPIES];
    }
    return sum == copies;
}

int native_loop_plan(struct native_loop *loop, int32_t turns_count, const int32_t *turns, int32_t copies_count,
                     const int32_t *copies, const double *changes, int32_t columns_count, const int32_t *columns,
                     int32_t before, const int32_t *timer)
{
    if (!turns_are_sound(loop, turns_count, turns, copies_count))
        return 1;
    for (int32_t i = 0; i < copies_count; i++) {
        const int32_t *copy = copies + COPY * i;
        if (!is_value(loop, copy[SOURCE], copy[FROM]) || !is_value(loop, copy[TARGET], copy[TO]))
            return 1;
    }
    for (int32_t i = 0; i < columns_count; i++)
        if (!is_value(loop, columns[2 * i], columns[2 * i + 1]))
            return 1;
    if (timer[0] >= 0 && !is_value(loop, timer[0], timer[1]))
        return 1;
    loop->turns_count = turns_count;
    loop->turns = turns;
    loop->copies = copies;
    loop->changes = changes;
    loop->columns_count = columns_count;
    loop->columns = columns;
    loop->before = before;
    loop->timer = timer;
    return 0;
}

/* -------------------------------------------------------------------------------------- the steps */

int native_loop_initialize(struct native_loop *loop)
{
    for (int32_t i = loop->count; i-- > 0;) {
        struct model *model = &loop->models[i]->model;
        model->clock[0] = model->clock[1] = 0;
        if (model->functions->initialize(model))
            return 1 + i;
    }
    return 0;
}

static void copy(const struct native_loop *loop, int32_t first, int32_t count)
{
    for (int32_t i = first; i < first + count; i++) {
        const int32_t *way = loop->copies + COPY * i;
        const double *change = loop->changes + 2 * i;
        const double value = loop->models[way[SOURCE]]->model.values[way[FROM]];
        const int is_same = change[0] == 1 && change[1] == 0; /* an exact copy preserves a negative zero */
        loop->models[way[TARGET]]->model.values[way[TO]] = is_same ? value : change[0] * value + change[1];
    }
}

/* Run the turns of one stage: copy the inputs of all of them, then step them. `turn` and `at` advance to the
 * turns and copies of the next stage. Return 0, or 1 + the model that failed. */
static int advance(struct native_loop *loop, int64_t k, double step, int32_t *turn, int32_t *at, double *time)
{
    const int32_t *turns = loop->turns, begin = *turn, stage = turns[TURN * begin + STAGE];
    for (; *turn < loop->turns_count && turns[TURN * *turn + STAGE] == stage; ++*turn) {
        const int32_t *own = turns + TURN * *turn;
        if (k % own[EVERY] == 0)
            copy(loop, *at, own[COPIES]);
        *at += own[COPIES];
    }
    for (const int32_t *own = turns + TURN * begin; own < turns + TURN * *turn; own += TURN) {
        struct model *model = &loop->models[own[MODEL]]->model;
        if (k % own[EVERY])
            continue;
        model->clock[0] = (double)k * step;
        model->clock[1] = (double)own[EVERY] * step;
        if (model->functions->step(model))
            return 1 + own[MODEL];
        if (own[MODEL] == loop->timer[0])
            *time = model->values[loop->timer[1]];
    }
    return 0;
}

void native_loop_record(const struct native_loop *loop, double time, double *row)
{
    row[0] = time;
    for (int32_t i = 0; i < loop->columns_count; i++)
        row[1 + i] = loop->models[loop->columns[2 * i]]->model.values[loop->columns[2 * i + 1]];
}

int native_loop_run(struct native_loop *loop, double step, int64_t first, int64_t count, double *rows,
                    double *times, int64_t done[2])
{
    const size_t width = 1 + (size_t)loop->columns_count;
    done[0] = done[1] = 0;
    for (int64_t k = first; k < first + count; k++, done[0]++) {
        int32_t turn = 0, at = 0, failed = 0;
        double *row = rows + width * (size_t)(k - first), *time = times + (k - first);
        while (!failed && turn < loop->turns_count && loop->turns[TURN * turn + STAGE] < loop->before)
            failed = advance(loop, k, step, &turn, &at, time);
        if (failed)
            return failed;
        native_loop_record(loop, (double)k * step, row);
        done[1]++;
        while (!failed && turn < loop->turns_count)
            failed = advance(loop, k, step, &turn, &at, time);
        if (failed)
            return failed;
    }
    return 0;
}
