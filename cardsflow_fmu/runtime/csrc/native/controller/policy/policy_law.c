#include "policy_law.h"

#include "../../../platform/clock.h"
#include "../ramp.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static size_t part_size(const struct controller *c, int part)
{
    const size_t sizes[] = {
        [POLICY_Q] = c->settings.of.q.count,
        [POLICY_QD] = c->settings.of.q.count,
        [POLICY_Y] = c->k,
        [POLICY_ERROR] = c->r,
        [POLICY_RATE] = c->r,
        [POLICY_ACTIVATIONS] = c->policy.activations,
    };
    return sizes[part];
}

/* Return whether all indices of the policy are within their ranges. */
static int fits(const struct controller *c)
{
    const policy *p = &c->policy;
    size_t inputs = 0;
    for (size_t i = 0; i < p->parts; i++) inputs += part_size(c, (int)p->part[i]);
    for (size_t i = 0; i < p->activations; i++)
        if (!(p->activation[i] >= 0 && p->activation[i] < (double)c->settings.of.states.count))
            return 0;
    for (size_t i = 0; i < p->outputs; i++) {
        const size_t count = p->target[2 * i] != 0 ? c->settings.of.commands.count : c->a;
        if (!(p->target[2 * i + 1] >= 0 && p->target[2 * i + 1] < (double)count))
            return 0;
    }
    return inputs == p->inputs;
}

int native_policy_open(struct controller *c)
{
    if (!c->settings.of.policy_numbers.count)
        return 0;
    policy *p = &c->policy;
    if (policy_open(p, c->settings.policy, c->settings.of.policy_numbers.count) || !fits(c))
        return 1;
    c->policy_scratch = calloc(p->inputs + 2 * p->width + p->outputs, sizeof *c->policy_scratch);
    return !c->policy_scratch;
}

void native_policy_close(struct controller *c)
{
    free(c->policy_scratch);
}

/* Write the observation. */
static void observe(const struct controller *c, const struct native_robot *robot, double *to)
{
    const policy *p = &c->policy;
    const double *position = c->reference, *rate = c->reference + c->r;
    for (size_t part = 0; part < p->parts; part++) {
        const int kind = (int)p->part[part];
        for (size_t i = 0; i < part_size(c, kind); i++) {
            const double y = c->k ? robot->task_values[c->settings.task_rows[i < c->k ? i : 0]] : 0;
            switch (kind) {
            case POLICY_Q: *to++ = c->q[i]; break;
            case POLICY_QD: *to++ = c->qd[i] * p->step; break;
            case POLICY_Y: *to++ = y; break;
            case POLICY_ERROR: *to++ = position[i] - (c->k ? y : c->q[i]); break;
            case POLICY_RATE: *to++ = rate[i] * p->step; break;
            default: *to++ = c->states[(size_t)p->activation[i]];
            }
        }
    }
}

/* Set an output. Ideal cables of a robot with muscle laws also have a command, their tension. */
static void set_output(struct controller *c, const double *target, double value)
{
    const size_t at = (size_t)target[1];
    if (target[0] != 0) {
        c->muscles.commands[c->settings.commanded[at]] = value;
        return;
    }
    c->forces[at] = value;
    if (at < c->muscles.m)
        c->muscles.commands[at] = value;
}

void native_policy_tick(struct controller *c, const struct native_robot *robot, double period)
{
    const policy *p = &c->policy;
    const double begin = monotonic_seconds();
    double *inputs = c->policy_scratch, *outputs = inputs + p->inputs + 2 * p->width;
    const int is_state_sound = !core_move_checked(robot->core, c->q, c->qd);
    if (is_state_sound)
        observe(c, robot, inputs);
    else
        inputs[0] = NAN;
    const int is_fallback = policy_evaluate(p, inputs, inputs + p->inputs, outputs);
    memset(c->forces, 0, c->a * sizeof(double));
    for (size_t i = 0; i < p->outputs; i++)
        set_output(c, p->target + 2 * i, outputs[i]);
    if (c->muscles.are_modelled && is_state_sound)
        native_muscles_hold(&c->muscles, robot, c->q, c->qd, c->states, c->forces);
    for (size_t i = 0; i < c->settings.of.commands.count; i++)
        c->commands[i] = c->muscles.commands[c->settings.commanded[i]];
    memcpy(c->in_loop.acting, c->forces, c->a * sizeof(double));
    native_ramp_up(c, period);
    memcpy(c->forces, c->in_loop.acting, c->a * sizeof(double));
    memset(c->slack, 0, c->r * sizeof(double));
    memset(c->report, 0, c->settings.of.report.count * sizeof(double));
    c->report[1] = monotonic_seconds() - begin;
    c->report[2] = is_fallback;
}
