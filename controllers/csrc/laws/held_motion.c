#include "held_motion.h"

static const real AT_ROW = 1e-9; /* in [s]: a time just before a row is that of the row */

size_t held_motion_width(const held_motion *motion)
{
    return motion->actuators + motion->controls + motion->extra + motion->controls * motion->states;
}

static size_t row_at(const held_motion *motion, real time)
{
    size_t low = 0, high = motion->rows;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (time + AT_ROW >= motion->begins[middle])
            low = middle;
        else
            high = middle;
    }
    return low;
}

const real *held_motion_row(const held_motion *motion, real time)
{
    return motion->values + row_at(motion, time) * held_motion_width(motion);
}

static void add_extra(const held_motion *motion, real time, const real *extra, real *deviation)
{
    const size_t width = held_motion_width(motion), row = row_at(motion, time);
    const real *now = motion->values + row * width + motion->actuators + motion->controls;
    const int is_last = row + 1 == motion->rows;
    const real *next = is_last ? now : now + width;
    const real length = is_last ? 1 : motion->begins[row + 1] - motion->begins[row];
    const real since = time - motion->begins[row], share = is_last || since < 0 ? 0 : since / length;
    for (size_t i = 0; i < motion->extra; i++)
        deviation[i] = now[i] + share * (next[i] - now[i]) - extra[i];
}

void held_motion_control(const held_motion *motion, real time, const real *extra, real *deviation, real *u)
{
    const real *held = held_motion_row(motion, time) + motion->actuators;
    const real *K = held + motion->controls + motion->extra;
    add_extra(motion, time, extra, deviation + motion->states - motion->extra);
    for (size_t i = 0; i < motion->controls; i++) {
        u[i] = held[i];
        for (size_t j = 0; j < motion->states; j++) u[i] += K[i * motion->states + j] * deviation[j];
    }
}
