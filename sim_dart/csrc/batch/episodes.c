#include "episodes.h"

#include "../blob/state.h"
#include "../math/elementary.h"

#include <math.h>
#include <string.h>

static core *instance(const episodes *e, int32_t k)
{
    return (core *)(void *)((char *)e->memory + (size_t)k * e->stride);
}

/* Return the next number from 0 to below 1 of SplitMix64 (G. Steele et al., Fast splittable pseudorandom number
   generators, 2014). */
static double draw(uint64_t *stream)
{
    uint64_t z = *stream += 0x9E3779B97F4A7C15U;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static void draw_between(uint64_t *stream, int is_drawn, const double *low, const double *high, int32_t count, double *x)
{
    for (int32_t i = 0; i < count; i++) x[i] = is_drawn ? low[i] + (high[i] - low[i]) * draw(stream) : low[i];
}

static void draw_targets(const episodes *e, uint64_t *stream, double *targets)
{
    const size_t width = (size_t)e->width;
    if (!e->points) {
        draw_between(stream, e->draws_targets, e->target_low, e->target_high, e->width, targets);
        return;
    }
    memcpy(targets, e->points + (size_t)(draw(stream) * e->point_count) * width, width * sizeof(double));
}

/* Make an instance a robot that is drawn from the variants. */
static void draw_variant(const episodes *e, uint64_t *stream, int32_t k)
{
    const int32_t variant = (int32_t)(draw(stream) * e->blob_count);
    if (variant == e->variants[k]) return;
    core_open(e->blobs[variant], e->blob_sizes[variant], instance(e, k));
    e->variants[k] = variant;
}

static void start(const episodes *e, int32_t k)
{
    core *c = instance(e, k);
    const size_t dofs = (size_t)c->blob.counts.dofs, muscles = (size_t)c->blob.counts.muscles, at = (size_t)k;
    const uint8_t yes = 1;
    uint64_t *stream = e->streams + k;
    draw_targets(e, stream, e->targets + at * (size_t)e->width);
    draw_between(stream, e->draws_q, e->q_low, e->q_high, (int32_t)dofs, e->q + at * dofs);
    if (e->blob_count > 1) draw_variant(e, stream, k);
    memcpy(e->commands + at * muscles, e->rest, muscles * sizeof(real));
    core_batch_reset(c, e->stride, 1, &yes, e->q + at * dofs, e->zeros, e->rest, e->answers + k);
    for (int32_t i = 0; i < e->activations && e->activation >= 0; i++)
        ((real *)(void *)c)[e->activation_columns[i]] = e->activation;
    e->ticks[k] = 0;
}

void core_episodes_start(const episodes *e, int32_t first, int32_t count, const uint8_t *chosen)
{
    for (int32_t k = 0; k < count; k++)
        if (chosen[k]) start(e, first + k);
}

/* Return the command that an action means. */
static double command(const episode_action *action, double value, int is_sigmoid)
{
    const double a = value < -1 ? -1 : value > 1 ? 1 : value;
    if (is_sigmoid && action->dof < 0) return 1 / (1 + exponential(-5 * (a - 0.5)));
    return (a + 1) * (0.5 * (action->high - action->low)) + action->low;
}

static void apply(const episodes *e, int32_t k, const double *values)
{
    const blob_counts *n = &instance(e, k)->blob.counts;
    real *commands = e->commands + (size_t)k * (size_t)n->muscles;
    real *torques = e->torques ? e->torques + (size_t)k * (size_t)n->dofs : NULL;
    for (int32_t i = 0; i < e->action_count; i++) {
        const episode_action *action = e->actions + i;
        const double u = command(action, values[i], e->is_sigmoid);
        if (action->dof < 0) commands[action->muscle] = u;
        else torques[action->dof] = u;
    }
}

static double feature_value(const episode_feature *feature, const real *state, const double *targets)
{
    double value = feature->column < 0 ? 0.0 : feature->scale * state[feature->column];
    if (feature->target >= 0) value += targets[feature->target];
    return value;
}

/* Write an observation, or zeros for a state that diverged. Compute the distance and the effort. */
static void observe(const episodes *e, int32_t k, float *observation, double norms[2])
{
    const real *state = (const real *)(const void *)instance(e, k);
    double *targets = e->targets + (size_t)k * (size_t)e->width, squares[2] = {0};
    if (e->reference_rows) {
        const int64_t last = e->reference_rows - 1, row = e->ticks[k] < last ? e->ticks[k] : last;
        memcpy(targets, e->reference + (size_t)row * (size_t)e->width, (size_t)e->width * sizeof(double));
    }
    for (int32_t j = 0; j < e->feature_count; j++) {
        const double value = feature_value(e->features + j, state, targets);
        observation[j] = e->answers[k] ? 0.0F : (float)value;
        if (e->features[j].norm >= 0) squares[e->features[j].norm] += value * value;
    }
    norms[0] = sqrt(squares[0]);
    norms[1] = sqrt(squares[1]) / (e->activations ? e->activations : 1);
}

void core_episodes_evaluate(const episodes *e, int32_t first, int32_t count, const uint8_t *ended, float *observations,
                            double *rewards, uint8_t *flags)
{
    const size_t n = (size_t)e->instances;
    for (int32_t k = first; k < first + count; k++, observations += e->feature_count) {
        double norms[2], terms[EPISODE_TERMS], reward = 0;
        observe(e, k, observations, norms);
        const int has_ended = ended && ended[k - first], has_diverged = e->answers[k] != 0;
        const int is_solved = norms[0] < e->near, is_done = norms[0] > e->far && e->ticks[k] >= e->first_end;
        terms[EPISODE_DISTANCE] = -norms[0];
        terms[EPISODE_BONUS] = is_solved + (norms[0] < e->beyond);
        terms[EPISODE_EFFORT] = -norms[1];
        terms[EPISODE_PENALTY] = -is_done;
        for (int32_t i = 0; i < EPISODE_TERMS; i++) reward += e->weights[i] * terms[i];
        if (has_diverged) reward = -e->weights[EPISODE_PENALTY];
        rewards[k] = has_ended ? 0 : reward;
        for (int32_t i = 0; i < EPISODE_TERMS; i++) rewards[(size_t)(i + 1) * n + (size_t)k] = terms[i];
        flags[EPISODE_TERMINATED * n + (size_t)k] = !has_ended && (is_done || has_diverged);
        flags[EPISODE_TRUNCATED * n + (size_t)k] = (double)e->ticks[k] >= e->last;
        flags[EPISODE_DONE * n + (size_t)k] = is_done;
        flags[EPISODE_SOLVED * n + (size_t)k] = is_solved;
        flags[EPISODE_DIVERGED * n + (size_t)k] = has_diverged;
    }
}

void core_episodes_step(const episodes *e, int32_t first, int32_t count, const double *actions, const uint8_t *ended,
                        void *group, float *observations, double *rewards, uint8_t *flags)
{
    const blob_counts *n = &instance(e, 0)->blob.counts;
    const size_t at = (size_t)first;
    int32_t *answers = e->answers + first;
    uint8_t *moving = e->moving + first;
    for (int32_t k = 0; k < count; k++, actions += e->action_count) {
        moving[k] = !ended || !ended[k];
        if (moving[k]) apply(e, first + k, actions);
        else start(e, first + k);
    }
    core_batch_step(instance(e, first), e->stride, count, moving, e->commands + at * (size_t)n->muscles,
                    e->torques ? e->torques + at * (size_t)n->dofs : NULL, e->h, e->steps, e->is_runge_kutta, group,
                    answers);
    for (int32_t k = 0; k < count; k++) e->ticks[first + k] += moving[k] && !answers[k];
    core_episodes_evaluate(e, first, count, ended, observations, rewards, flags);
}
