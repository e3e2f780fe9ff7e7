#include "native_loop.h"

#include "../../../cosim/csrc/master.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct native_loop {
    int32_t count;
    const int32_t *turns;
    struct master *master;
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
    if (loop->master)
        master_close(loop->master);
    free(loop);
}

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

static int are_values(const struct native_loop *loop, int32_t count, const int32_t *places)
{
    for (int32_t i = 0; i < count; i++)
        if (!is_value(loop, places[2 * i], places[2 * i + 1]))
            return 0;
    return 1;
}

static double *value(const struct native_loop *loop, const int32_t *place)
{
    return &loop->models[place[0]]->model.values[place[1]];
}

static int step_model(void *model, double t, double h)
{
    return native_model_step(model, t, h);
}

static void add_copy(const struct native_loop *loop, const int32_t *copy, const double *change)
{
    const int form = change[0] == 1 && change[1] == 0 ? COPY_EXACT : COPY_SCALED;
    master_add_copy(loop->master, 0, value(loop, copy + SOURCE), value(loop, copy + TARGET), form, change[0],
                    change[1]);
}

int native_loop_plan(struct native_loop *loop, int32_t turns_count, const int32_t *turns, int32_t copies_count,
                     const int32_t *copies, const double *changes)
{
    if (!turns_are_sound(loop, turns_count, turns, copies_count) || !are_values(loop, 2 * copies_count, copies))
        return 1;
    struct master *master = loop->master = master_open(turns_count, copies_count, 0);
    if (!master)
        return 1;
    loop->turns = turns;
    for (int32_t i = 0; i < turns_count; i++) {
        const int32_t *turn = turns + TURN * i;
        master_add_turn(master, step_model, loop->models[turn[MODEL]], turn[EVERY], turn[STAGE]);
        for (int32_t k = 0; k < turn[COPIES]; k++, copies += COPY, changes += 2)
            add_copy(loop, copies, changes);
    }
    return 0;
}

int native_loop_run(struct native_loop *loop, double step, int64_t first, int64_t count, int64_t *done)
{
    double times[NATIVE_LOOP_STEPS]; /* rows without columns */
    struct master_progress progress;
    master_set_step(loop->master, step, 0);
    const int end = master_run(loop->master, first, count, INFINITY, times, NULL, &progress);
    *done = progress.done;
    return end == MASTER_FAILED ? 1 + loop->turns[TURN * progress.turn + MODEL] : 0;
}
