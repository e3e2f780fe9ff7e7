#include "sensitivity.h"

#include "tangent.h"

#include <string.h>

#if HAS_CORE_TANGENT

#include "../blob/state.h"

struct core_sensitivity {
    core_tangent *tangent;
    const core *plain;
    size_t n, m, numbers;
    double *none; /* zeros, as many as the blob has numbers, or a measurement */
    double *of_start, *reading, *states, *state_changes;
};

/* A roll-out, and the changes in it. */
typedef struct {
    const double *q, *qd, *commands, *torques;
    int32_t rows, steps;
    double h;
} roll;

static size_t longest(const core *plain)
{
    const size_t reading = (size_t)plain->blob.counts.dofs + (size_t)plain->blob.counts.muscles;
    const size_t numbers = core_tangent_robot_numbers(plain);
    return numbers > reading ? numbers : reading;
}

static size_t own_numbers(const core *plain)
{
    const size_t states = 2 * (size_t)plain->blob.law_states;
    return longest(plain) + 2 * (size_t)plain->blob.counts.dofs + (size_t)plain->blob.counts.muscles + states;
}

size_t core_sensitivity_numbers(const core *plain)
{
    return core_tangent_robot_numbers(plain);
}

size_t core_sensitivity_size(const core *plain)
{
    return sizeof(core_sensitivity) + own_numbers(plain) * sizeof(double) + core_tangent_size(plain);
}

core_sensitivity *core_sensitivity_open(const core *plain, void *memory)
{
    core_sensitivity *s = memory;
    s->n = (size_t)plain->blob.counts.dofs, s->m = (size_t)plain->blob.counts.muscles;
    s->numbers = core_tangent_robot_numbers(plain);
    s->none = (double *)(void *)(s + 1);
    memset(s->none, 0, own_numbers(plain) * sizeof(double));
    s->of_start = s->none + longest(plain);
    s->reading = s->of_start + s->n;
    s->states = s->reading + s->n + s->m;
    s->state_changes = s->states + plain->blob.law_states;
    s->plain = plain;
    s->tangent = core_tangent_open(plain, s->none + own_numbers(plain));
    return s;
}

/* Copy the states of cable friction from the plain handle. */
static void copy_slips(const core_sensitivity *s)
{
    const size_t bends = (size_t)s->plain->blob.counts.bends, others = (size_t)s->plain->blob.law_states - bends;
    if (!bends) return;
    core_tangent_values(s->tangent, TANGENT_STATES, s->states);
    core_tangent_changes(s->tangent, TANGENT_STATES, s->state_changes);
    memcpy(s->states + others, s->plain->law_states + others, bends * sizeof(double));
    core_tangent_set(s->tangent, TANGENT_STATES, s->states, s->state_changes);
}

/* Simulate through the measurements. `derivatives` is a column of their derivatives, with elements `stride`
   numbers apart. */
static int simulate(const core_sensitivity *s, const roll *roll, const double *dq, const double *dqd, const double *dcommands,
                    double *readings, double *derivatives, size_t stride)
{
    const size_t n = s->n, m = s->m;
    core_tangent_set(s->tangent, TANGENT_Q, roll->q, dq);
    core_tangent_set(s->tangent, TANGENT_QD, roll->qd, dqd);
    core_tangent_set(s->tangent, TANGENT_COMMANDS, roll->commands, s->none);
    if (core_tangent_move(s->tangent) || core_tangent_start(s->tangent)) return 1;
    copy_slips(s);
    for (int32_t row = 0; row < roll->rows; row++) {
        core_tangent_values(s->tangent, TANGENT_Q, readings + (size_t)row * (n + m));
        core_tangent_values(s->tangent, TANGENT_LENGTHS, readings + (size_t)row * (n + m) + n);
        if (derivatives) {
            core_tangent_changes(s->tangent, TANGENT_Q, s->reading);
            for (size_t k = 0; k < n; k++, derivatives += stride) *derivatives = s->reading[k];
            core_tangent_changes(s->tangent, TANGENT_LENGTHS, s->reading);
            for (size_t k = 0; k < m; k++, derivatives += stride) *derivatives = s->reading[k];
        }
        const double *change = dcommands ? dcommands + (size_t)row * m : s->none;
        core_tangent_set(s->tangent, TANGENT_COMMANDS, roll->commands + (size_t)row * m, change);
        core_tangent_set(s->tangent, TANGENT_TORQUES, roll->torques + (size_t)row * n, s->none);
        if (row + 1 < roll->rows && core_tangent_step(s->tangent, roll->h, roll->steps)) return 2 + row;
    }
    return 0;
}

int core_sensitivity_roll(core_sensitivity *s, const double *q, const double *qd, int32_t rows, int32_t steps,
                          double h, const double *commands, const double *torques, int32_t directions,
                          const double *robot_changes, const double *command_changes,
                          const int32_t *commanded, double *readings, double *derivatives)
{
    const roll roll = {q, qd, commands, torques, rows, steps, h};
    const size_t stride = (size_t)directions + 2 * s->n;
    for (size_t k = 0; k < (size_t)directions; k++) {
        core_tangent_change_robot(s->tangent, robot_changes + k * s->numbers);
        const size_t size = (size_t)rows * s->m;
        const double *dcommands = commanded[k] < 0 ? NULL : command_changes + (size_t)commanded[k] * size;
        const int bad = simulate(s, &roll, s->none, s->none, dcommands, readings, derivatives + k, stride);
        if (bad) return bad;
    }
    core_tangent_change_robot(s->tangent, s->none);
    if (!derivatives) return simulate(s, &roll, s->none, s->none, NULL, readings, NULL, 0);
    for (size_t j = 0; j < 2 * s->n; j++) {
        s->of_start[j % s->n] = 1;
        const double *dq = j < s->n ? s->of_start : s->none, *dqd = j < s->n ? s->none : s->of_start;
        const int bad = simulate(s, &roll, dq, dqd, NULL, readings, derivatives + (size_t)directions + j, stride);
        s->of_start[j % s->n] = 0;
        if (bad) return bad;
    }
    return 0;
}

#else
typedef int no_sensitivity; /* ISO C forbids empty translation units */
#endif
