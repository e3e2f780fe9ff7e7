#include "muscles.h"

#include "../../../../../sim_dart/csrc/math/elementary.h"

#include <stdlib.h>
#include <string.h>

int native_muscles_open(struct native_muscles *muscles, const struct native_robot *robot,
                        const struct controller_settings *settings)
{
    const size_t m = muscles->m = robot->m;
    muscles->settings = settings;
    muscles->are_modelled = settings->of.modelled.count != 0;
    muscles->memory = calloc(7 * m + 1, sizeof *muscles->memory);
    if (!muscles->memory)
        return 1;
    muscles->commands = muscles->memory;
    muscles->began = muscles->commands + m;
    muscles->has_ticked = muscles->began + m;
    muscles->applied = muscles->has_ticked + 1;
    muscles->passive_push = muscles->applied + m;
    muscles->least = muscles->passive_push + m;
    muscles->most = muscles->least + m;
    muscles->inner = muscles->most + m;
    return 0;
}

void native_muscles_close(struct native_muscles *muscles)
{
    free(muscles->memory);
}

size_t native_muscles_memory(const struct native_muscles *muscles)
{
    return muscles->are_modelled ? 2 * muscles->m + 1 : 0;
}

void native_muscles_reset(struct native_muscles *muscles)
{
    memcpy(muscles->commands, muscles->settings->start_commands, muscles->m * sizeof(double));
    memset(muscles->began, 0, muscles->m * sizeof(double));
    muscles->has_ticked[0] = 0;
}

static double horizon_of(const struct native_muscles *muscles, double period)
{
    const double horizon = muscles->settings->muscle_horizon[0];
    return horizon > 0 ? larger(horizon, period) : muscles->settings->late_periods[0] * period;
}

static void move_core(const struct native_robot *robot, const double *q, const double *qd)
{
    core_move(robot->core, q);
    core_rates(robot->core, qd);
}

/* Compute the tensions for the current commands, at the last rates of the core. */
static void drive(struct native_muscles *muscles, const struct native_robot *robot, const double *qd)
{
    memcpy(muscles->inner, muscles->commands, muscles->m * sizeof(double));
    if (muscles->outside.forces)
        muscles->outside.forces(muscles->outside.self, muscles->commands, muscles->inner);
    core_drive(robot->core, qd, muscles->inner);
}

/* Compute the tensions at a state. */
static void drive_at(struct native_muscles *muscles, const struct native_robot *robot, const double *q, const double *qd,
                     const double *states)
{
    move_core(robot, q, qd);
    for (size_t i = 0; i < muscles->settings->of.states.count; i++)
        robot->states[muscles->settings->state_order[i]] = states[i];
    drive(muscles, robot, qd);
}

void native_muscles_hold(struct native_muscles *muscles, const struct native_robot *robot, const double *q,
                         const double *qd, const double *states, double *forces)
{
    drive_at(muscles, robot, q, qd, states);
    memcpy(forces, robot->tensions, muscles->m * sizeof(double));
    memcpy(muscles->began, robot->tensions, muscles->m * sizeof(double));
    muscles->has_ticked[0] = 1;
}

void native_muscles_set_state(struct native_muscles *muscles, const struct native_robot *robot, const double *q,
                              const double *qd, const double *states, const double *f_min, const double *f_max,
                              double period)
{
    const double *low = robot->force_low, *high = robot->force_high;
    drive_at(muscles, robot, q, qd, states);
    for (size_t i = 0; i < muscles->m; i++)
        muscles->applied[i] = 0.5 * (muscles->began[i] + robot->tensions[i]);
    core_reach(robot->core, horizon_of(muscles, period));
    if (muscles->outside.reach)
        muscles->outside.reach(muscles->outside.self);
    for (size_t i = 0; i < muscles->m; i++) {
        const double least = smaller(larger(f_min[i], low[i]), high[i]);
        const double most = smaller(larger(f_max[i], low[i]), high[i]);
        muscles->least[i] = larger(least, 0);
        muscles->most[i] = larger(most, 0);
        muscles->passive_push[i] = smaller(most, 0);
    }
}

/* Set the commands at the position and rates of the core. */
static void set_commands(struct native_muscles *muscles, const struct native_robot *robot, const double *qd,
                         const double *commands)
{
    memcpy(muscles->commands, commands, muscles->m * sizeof(double));
    drive(muscles, robot, qd);
    memcpy(muscles->began, robot->tensions, muscles->m * sizeof(double));
    muscles->has_ticked[0] = 1;
}

void native_muscles_update(struct native_muscles *muscles, const struct native_robot *robot, const double *q,
                           const double *qd, const double *forces, double period)
{
    move_core(robot, q, qd);
    core_invert(robot->core, forces, horizon_of(muscles, period), period);
    if (muscles->outside.invert)
        muscles->outside.invert(muscles->outside.self, forces);
    set_commands(muscles, robot, qd, robot->commands);
}

void native_muscles_command(struct native_muscles *muscles, const struct native_robot *robot, const double *q,
                            const double *qd, const double *commands)
{
    move_core(robot, q, qd);
    set_commands(muscles, robot, qd, commands);
}
