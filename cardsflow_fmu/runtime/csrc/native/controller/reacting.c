#include "reacting.h"

#include "../../../../../controllers/csrc/reaction/reaction.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double PATIENCE = 0.5; /* in [s] */
static const double AT_REST = 0.02, MOVES_AGAIN = 0.1; /* speeds of joints, in [rad/s] or [m/s] */
static const double RECOVERY = 0.3, STIFFER = 3; /* time of higher gains after a loss, in [s]; initial factor */
static const double MAX_RATE = 0.6; /* maximum product of kd and the period with higher gains */

/* Arrays of the law in operational space that change while the joints are braked. */
#define BRAKED_ARRAYS(ARRAY) ARRAY(W) ARRAY(posture_kp) ARRAY(posture_kd) ARRAY(q0) ARRAY(limit_bandwidth) ARRAY(H_q)
enum { BRAKED = 6 };

struct reacting {
    reaction decision;
    size_t n, length;  /* of the internal state */
    double *state;     /* that of the decision; the time since the last loss; whether a pose is held; the pose, n */
    double *since, *is_holding, *pose; /* time since the last loss, in [s] */
    double *bounds;
    double *reference;     /* 3 r: at rest */
    struct {
        double *array, *normal;
        size_t length;
    } braked[BRAKED];
};

static int is_stopping(const struct reacting *p)
{
    return (int)p->decision.state[0] == REACTION_STOP;
}

/* The pose to hold follows the joints until they are at rest. */
static void update_pose(struct reacting *p, const struct controller *c)
{
    double fastest = 0;
    for (size_t j = 0; j < p->n; j++)
        fastest = fmax(fastest, fabs(c->qd[j]));
    if (p->is_holding[0] != 0 && fastest <= MOVES_AGAIN)
        return;
    p->is_holding[0] = fastest <= AT_REST;
    memcpy(p->pose, c->q, p->n * sizeof(double));
}

static void fill(double *values, size_t count, double value)
{
    for (size_t i = 0; i < count; i++)
        values[i] = value;
}

static double smallest(const double *values, size_t count)
{
    double least = values[0];
    for (size_t i = 1; i < count; i++)
        least = fmin(least, values[i]);
    return least;
}

/* Set the law in operational space to brake the joints, or to its own settings. */
static void set_law(struct reacting *p, const struct controller *c)
{
    size_t length;
    for (size_t k = 0; k < BRAKED; k++)
        memcpy(p->braked[k].array, p->braked[k].normal, p->braked[k].length * sizeof(double));
    if (!is_stopping(p))
        return;
    fill(p->braked[0].array, c->k, 1); /* the rows of the tasks are empty */
    fill(p->braked[1].array, p->n, smallest(c->kp, c->r));
    fill(p->braked[2].array, p->n, smallest(c->kd, c->r));
    memcpy(p->braked[3].array, p->pose, p->n * sizeof(double));
    p->braked[4].array[0] = 0; /* no violent motion of other joints for the limit of one */
    /* Joints with a large inertia hold, rather than moving together with a joint that has no muscle. */
    const double *M = loop_array(c, "M", &length);
    for (size_t j = 0; j < p->n; j++)
        p->braked[5].array[j] = M[j * p->n + j];
}

void native_reacting_limit(const struct controller *c, double *f_min, double *f_max)
{
    const struct reacting *p = c->reacting;
    for (size_t i = 0; p && i < p->decision.muscles; i++) {
        const size_t k = c->settings.bounded[i];
        if (!(p->bounds[i] < c->settings.full_bounds[i]))
            continue;
        f_max[k] = fmin(f_max[k], fmax(0, p->bounds[i]));
        f_min[k] = fmin(f_min[k], f_max[k]);
    }
}

/* Raise the gains after a loss: the motion until its detection is corrected sooner. */
static void stiffen(const struct reacting *p, const struct controller *c)
{
    const double remaining = fmax(0, 1 - p->since[0] / RECOVERY);
    for (size_t i = 0; i < c->r; i++) {
        const double most = fmax(1, MAX_RATE / (c->kd[i] * c->period[0]));
        const double factor = 1 + (fmin(STIFFER, most) - 1) * remaining;
        c->in_loop.kp[i] *= factor * factor;
        c->in_loop.kd[i] *= factor;
    }
}

const double *native_reacting_set(struct controller *c, const struct native_robot *robot)
{
    struct reacting *p = c->reacting;
    if (!p)
        return c->reference;
    for (size_t i = 0; i < p->decision.muscles; i++)
        p->bounds[i] = isnan(c->bounds[i]) ? c->settings.full_bounds[i] : c->bounds[i];
    const size_t lost = reaction_lost(&p->decision);
    reaction_decide(&p->decision, c->reached[0], p->bounds, c->settings.full_bounds);
    if (reaction_lost(&p->decision) > lost)
        p->since[0] = 0;
    stiffen(p, c);
    native_reacting_limit(c, c->in_loop.f_min, c->in_loop.f_max);
    if (is_stopping(p))
        update_pose(p, c);
    if (c->k)
        set_law(p, c);
    if (!is_stopping(p))
        return c->reference;
    if (!c->k)
        memcpy(p->reference, p->pose, robot->n * sizeof(double));
    return p->reference;
}

void native_reacting_finish(struct controller *c, double period, int is_infeasible)
{
    struct reacting *p = c->reacting;
    if (!p)
        return;
    reaction_report(&p->decision, period, is_infeasible);
    p->since[0] += period;
    c->reaction[0] = reaction_speed(&p->decision);
    c->reaction[1] = p->decision.state[0];
    c->reaction[2] = (double)reaction_lost(&p->decision);
}

int native_reacting_releases_tasks(const struct controller *c)
{
    return c->reacting && is_stopping(c->reacting);
}

double *native_reacting_memory(const struct controller *c, size_t *length)
{
    *length = c->reacting ? c->reacting->length : 0;
    return c->reacting ? c->reacting->state : c->last_position;
}

void native_reacting_reset(struct controller *c)
{
    struct reacting *p = c->reacting;
    if (!p)
        return;
    reaction_reset(&p->decision);
    memset(p->is_holding, 0, (1 + p->n) * sizeof(double));
    p->since[0] = RECOVERY;
    native_reacting_finish(c, 0, 0);
}

void native_reacting_close(struct controller *c)
{
    if (!c->reacting)
        return;
    free(c->reacting->state);
    free(c->reacting);
}

/* Find the arrays of the law, whose values are those of the settings, and copy them to `at`. */
static void copy_normal(struct reacting *p, const struct controller *c, double *at)
{
    size_t k = 0;
#define COPY(name)                                                                                            \
    p->braked[k].array = loop_array(c, #name, &p->braked[k].length);                                          \
    memcpy(p->braked[k].normal = at, p->braked[k].array, p->braked[k].length * sizeof(double));               \
    at += p->braked[k].length, k++;
    BRAKED_ARRAYS(COPY)
#undef COPY
}

int native_reacting_open(struct controller *c, const struct native_robot *robot, struct text *error)
{
    const struct controller_settings *s = &c->settings;
    const size_t m = s->of.bounds.count, n = robot->n, times = s->of.reaction_times.count;
    if (!m)
        return 0;
    struct reacting *p = c->reacting = calloc(1, sizeof *p);
    const size_t length = reaction_state_length(m) + 2 + n, normal = c->k + 4 * n + 1;
    if (!p || !(p->state = calloc(length + m + 3 * c->r + normal, sizeof *p->state))) {
        text_set(error, "not enough memory for the controller");
        return 1;
    }
    if (s->of.reached.count != 1 || s->of.reaction.count != 3 || s->of.reaction_numbers.count != m * times ||
        !native_all_below(s->bounded, m, robot->m)) {
        text_set(error, "native.bin does not match its controller");
        return 1;
    }
    p->n = n, p->length = length;
    p->since = p->state + reaction_state_length(m), p->is_holding = p->since + 1, p->pose = p->is_holding + 1;
    p->bounds = p->state + length, p->reference = p->bounds + m;
    p->decision = (reaction){m, times, s->reaction_begins, s->reaction_speeds, PATIENCE, p->state};
    if (c->k)
        copy_normal(p, c, p->reference + 3 * c->r);
    return 0;
}
