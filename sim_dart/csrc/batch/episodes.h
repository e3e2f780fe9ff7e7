/* Episodes of many instances, for learning: starts, commands for actions, observations and rewards. */
#ifndef CARDSFLOW_BATCH_EPISODES_H
#define CARDSFLOW_BATCH_EPISODES_H

#include "batch.h"

/* Range of the command of a muscle, or of the torque of a motor; the index of the other one is -1. */
typedef struct {
    int32_t muscle, dof;
    double low, high;
} episode_action;

/* Linear function of a number in the working memory of an instance and of its targets. */
typedef struct {
    int32_t column; /* index of the number; -1 without one */
    int32_t target; /* index of the target that is added; -1 without one */
    int32_t norm;   /* 0: distance, 1: effort, the norms that include this value; -1: none */
    int32_t unused;
    double scale; /* factor of the number */
} episode_feature;

/* Weights of the terms of a reward: -distance, the bonus, -effort, and -1 where the distance is above `far`. */
enum episode_term { EPISODE_DISTANCE, EPISODE_BONUS, EPISODE_EFFORT, EPISODE_PENALTY, EPISODE_TERMS };

/* Rows of the results of core_episodes_evaluate, each with one value per instance. */
enum episode_flag { EPISODE_TERMINATED, EPISODE_TRUNCATED, EPISODE_DONE, EPISODE_SOLVED, EPISODE_DIVERGED };

/* Instances of batch.h, and the rules of their episodes. */
typedef struct {
    void *memory;
    size_t stride;
    int32_t instances, width; /* number of targets of an instance */
    /* Arrays with one row per instance: */
    uint64_t *streams; /* states of the generator SplitMix64 */
    int64_t *ticks;
    double *targets;
    real *q, *commands, *torques; /* q at the start */
    int32_t *answers, *variants;
    uint8_t *moving;
    /* Starts. q and targets are drawn between low and high, or targets from the rows of `points`; see `draws`. */
    const double *target_low, *target_high, *points, *q_low, *q_high;
    int32_t draws_targets, draws_q, point_count;
    int32_t blob_count; /* robots of which an episode draws one */
    const void *const *blobs;
    const size_t *blob_sizes;
    const real *zeros, *rest; /* velocities; commands in whose equilibrium the muscles start */
    const int32_t *activation_columns;
    int32_t activations;
    int32_t reference_rows; /* targets at each tick instead of constant ones, if above 0 */
    const double *reference;
    double activation; /* at the start instead of that of the equilibrium, if not negative */
    /* Steps */
    const episode_action *actions;
    int32_t action_count, is_sigmoid;
    double h;
    int32_t steps, is_runge_kutta;
    /* Observations and rewards. The bonus is 1 below the distance `beyond` and 2 below `near`. */
    const episode_feature *features;
    int32_t feature_count, first_end; /* first tick with which an episode can end */
    double near, beyond, far, weights[EPISODE_TERMS];
    double last; /* ticks of an episode, or infinity */
} episodes;

/* Start an episode of each of `count` instances from `first` on with a nonzero `chosen`, count flags. */
CORE_API void core_episodes_start(const episodes *e, int32_t first, int32_t count, const uint8_t *chosen);

/* Write the observations, count x feature_count; the rewards and the terms, (1 + EPISODE_TERMS) x instances; and the
   flags, 5 x instances. Rewards of instances with a nonzero `ended`, count flags or NULL, are 0; others that diverged
   have the penalty. */
CORE_API void core_episodes_evaluate(const episodes *e, int32_t first, int32_t count, const uint8_t *ended,
                                     float *observations, double *rewards, uint8_t *flags);

/* Start an episode of each instance with a nonzero `ended`, step the others with actions from -1 to 1,
   count x action_count, and evaluate all. Values beyond are clipped. `group` as for core_batch_step. */
CORE_API void core_episodes_step(const episodes *e, int32_t first, int32_t count, const double *actions,
                                 const uint8_t *ended, void *group, float *observations, double *rewards,
                                 uint8_t *flags);

#endif
