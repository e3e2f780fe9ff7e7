#include "reaction.h"

#include <string.h>

enum { DECISION, SPEED, INFEASIBLE_TIME, LOST /* and one element per muscle */ };

size_t reaction_state_length(size_t muscles)
{
    return LOST + muscles;
}

void reaction_reset(reaction *s)
{
    memset(s->state, 0, reaction_state_length(s->muscles) * sizeof(real));
    s->state[SPEED] = 1;
}

/* Return the column of the table for a time: the last one that begins at the time or before. */
static size_t column_at(const reaction *s, real time)
{
    size_t low = 0, high = s->times;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (time >= s->begins[middle]) low = middle;
        else high = middle;
    }
    return low;
}

static void make_more_severe(reaction *s, int decision, real speed)
{
    if (decision > s->state[DECISION]) s->state[DECISION] = decision;
    if (speed < s->state[SPEED]) s->state[SPEED] = speed;
    if (s->state[DECISION] >= REACTION_HOLD) s->state[SPEED] = 0;
}

/* Apply the value of the table for a lost muscle. */
static void lose(reaction *s, size_t muscle, size_t column)
{
    const real value = s->times ? s->speeds[muscle * s->times + column] : REACTION_POSE;
    s->state[LOST + muscle] = 1;
    s->state[INFEASIBLE_TIME] = 0;
    if (value >= 1) make_more_severe(s, REACTION_CONTINUE, 1);
    else if (value > REACTION_POSE) make_more_severe(s, REACTION_SLOW, value);
    else make_more_severe(s, value == REACTION_POSE ? REACTION_HOLD : REACTION_STOP, 0);
}

int reaction_decide(reaction *s, real path_time, const real *bounds, const real *f_max)
{
    const size_t column = column_at(s, path_time);
    for (size_t i = 0; i < s->muscles; i++)
        if (s->state[LOST + i] == 0 && bounds[i] < f_max[i]) lose(s, i, column);
    return (int)s->state[DECISION];
}

void reaction_report(reaction *s, real h, int is_infeasible)
{
    if (s->state[DECISION] == REACTION_NONE || s->state[DECISION] == REACTION_STOP) return;
    s->state[INFEASIBLE_TIME] = is_infeasible ? s->state[INFEASIBLE_TIME] + h : 0;
    if (s->state[INFEASIBLE_TIME] <= s->patience) return;
    make_more_severe(s, s->state[DECISION] < REACTION_HOLD ? REACTION_HOLD : REACTION_STOP, 0);
    s->state[INFEASIBLE_TIME] = 0;
}

real reaction_speed(const reaction *s)
{
    return s->state[SPEED];
}

size_t reaction_lost(const reaction *s)
{
    size_t count = 0;
    for (size_t i = 0; i < s->muscles; i++) count += s->state[LOST + i] != 0;
    return count;
}
