#include "shooting.h"

#include "rate_jacobian.h"

#include <string.h>

#if HAS_CORE_TANGENT

#include "../blob/state.h"
#include "../integrators/runge_kutta.h"

struct core_shooting {
    core *plain;
    rate_jacobian *rates;
    size_t n, m, width, across; /* width: numbers in a state; across: number of directions */
    const int32_t *inputs;
    const double *controls;        /* of the interval */
    double *start, *at, *sum, *slope; /* derivatives of a state, or of its rates: width x across */
    double *none;                     /* zeros, as many as the blob has numbers or any array */
};

static size_t width_of(const core *plain)
{
    return 2 * (size_t)plain->blob.counts.dofs + (size_t)plain->blob.law_states;
}

/* Return the maximum number of derivatives of a state. */
static size_t derivatives_of(const core *plain)
{
    const size_t controls = (size_t)plain->blob.counts.muscles + (size_t)plain->blob.counts.dofs;
    return width_of(plain) * (width_of(plain) + controls + 1);
}

/* Return an upper bound of the length of `none`. */
static size_t zeros_of(const core *plain)
{
    return core_tangent_robot_numbers(plain) + width_of(plain) + (size_t)plain->blob.counts.muscles;
}

size_t core_shooting_size(const core *plain)
{
    if (plain->blob.counts.bends) return 0;
    const size_t numbers = 3 * derivatives_of(plain) + zeros_of(plain);
    return sizeof(core_shooting) + numbers * sizeof(double) + rate_jacobian_size(plain);
}

core_shooting *core_shooting_open(core *plain, void *memory)
{
    core_shooting *s = memory;
    const size_t length = derivatives_of(plain);
    s->plain = plain;
    s->n = (size_t)plain->blob.counts.dofs, s->m = (size_t)plain->blob.counts.muscles;
    s->width = width_of(plain);
    s->at = (double *)(void *)(s + 1);
    s->sum = s->at + length, s->slope = s->sum + length;
    s->none = s->slope + length;
    memset(s->none, 0, zeros_of(plain) * sizeof(double));
    s->rates = rate_jacobian_open(plain, s->none + zeros_of(plain));
    return s;
}

/* Compute to += scale * slope. */
static void add(size_t count, double scale, const double *restrict slope, double *restrict to)
{
    for (size_t k = 0; k < count; k++) to[k] += scale * slope[k];
}

/* Compute the derivatives of the rates of a stage from those of its state. */
static void multiply(const core_shooting *s, const double *jacobian)
{
    const size_t columns = s->width + s->m + s->n;
    memset(s->slope, 0, s->width * s->across * sizeof(double));
    for (size_t i = 0; i < s->width; i++) {
        double *row = s->slope + i * s->across;
        const double *own = jacobian + i * columns;
        for (size_t k = 0; k < s->width; k++)
            if (own[k] != 0) add(s->across, own[k], s->at + k * s->across, row);
        for (size_t j = 0; j < s->across; j++) {
            const size_t input = (size_t)s->inputs[j];
            if (input >= s->width && input < columns) row[j] += own[input];
        }
    }
}

/* Add the derivative by h of a move by share * h * rates. */
static void add_duration(const core_shooting *s, double share, const double *qd, const double *qdd, const double *states,
                         double *to)
{
    for (size_t j = 0; j < s->across; j++) {
        if ((size_t)s->inputs[j] != s->width + s->m + s->n) continue;
        for (size_t i = 0; i < s->width; i++) {
            const double *rates = i < s->n ? qd + i : i < 2 * s->n ? qdd + (i - s->n) : states + (i - 2 * s->n);
            to[i * s->across + j] += share * *rates;
        }
    }
}

/* Multiply the derivatives of q and qd by those of loops_close. */
static void close_loops(const core_shooting *s)
{
    const double *jacobian = rate_jacobian_close(s->rates);
    const size_t rows = 2 * s->n;
    memset(s->slope, 0, rows * s->across * sizeof(double));
    for (size_t i = 0; i < rows; i++)
        for (size_t k = 0; k < rows; k++) {
            double *row = s->slope + i * s->across;
            add(s->across, jacobian[i * rows + k], s->start + k * s->across, row);
        }
    memcpy(s->start, s->slope, rows * s->across * sizeof(double));
}

/* A stage_observer: advance the derivatives like the state. */
static void follow(void *self, int stage, double h)
{
    static const double weights[4] = {1, 2, 2, 1}, shares[3] = {0.5, 0.5, 1};
    core_shooting *s = self;
    const core *c = s->plain;
    const size_t count = s->width * s->across;
    if (stage == 4) {
        close_loops(s);
        return;
    }
    if (stage == 0) {
        memcpy(s->at, s->start, count * sizeof(double));
        memset(s->sum, 0, count * sizeof(double));
    }
    if (h != 0) {
        multiply(s, rate_jacobian_fill(s->rates, s->controls, s->controls + s->m));
        add(count, weights[stage], s->slope, s->sum);
    }
    if (stage < 3) {
        memcpy(s->at, s->start, count * sizeof(double));
        if (h != 0) add(count, shares[stage] * h, s->slope, s->at);
        add_duration(s, shares[stage], c->qd, c->qdd, c->law_rates, s->at);
    } else {
        add(count, h / 6, s->sum, s->start);
        add_duration(s, 1.0 / 6, c->slopes, c->slopes + s->n, c->slopes + 2 * s->n, s->start);
    }
}

/* Set the derivatives at the start: 1 for the states among the inputs. */
static void begin(core_shooting *s, double *derivatives)
{
    s->start = derivatives;
    memset(derivatives, 0, s->width * s->across * sizeof(double));
    for (size_t j = 0; j < s->across; j++)
        if ((size_t)s->inputs[j] < s->width) derivatives[(size_t)s->inputs[j] * s->across + j] = 1;
}

/* Simulate an interval. */
static int simulate(core_shooting *s, int32_t steps, double h, const double *start, double *end)
{
    core *c = s->plain;
    const size_t states = s->width - 2 * s->n;
    memcpy(c->q, start, s->n * sizeof(double));
    memcpy(c->qd, start + s->n, s->n * sizeof(double));
    memcpy(c->law_states, start + 2 * s->n, states * sizeof(double));
    if (core_move_checked(c, c->q, c->qd)) return 1;
    if (runge_kutta_observed(c, s->controls, s->controls + s->m, h, steps, s->across ? follow : NULL, s)) return 1;
    memcpy(end, c->q, s->n * sizeof(double));
    memcpy(end + s->n, c->qd, s->n * sizeof(double));
    memcpy(end + 2 * s->n, c->law_states, states * sizeof(double));
    return 0;
}

int core_shooting_run(core_shooting *s, int32_t count, int32_t steps, const double *h, const double *starts,
                      const double *controls, int32_t directions, const int32_t *inputs, double *ends,
                      double *derivatives)
{
    s->across = (size_t)directions, s->inputs = inputs;
    for (int32_t k = 0; k < count; k++) {
        s->controls = controls + (size_t)k * (s->m + s->n);
        if (s->across) begin(s, derivatives + (size_t)k * s->width * s->across);
        if (simulate(s, steps, h[k], starts + (size_t)k * s->width, ends + (size_t)k * s->width)) return 1 + k;
    }
    return 0;
}

/* Simulate an interval along the change of the robot. */
static int simulate_along(core_tangent *t, int32_t steps, double h, const core_shooting *s, const double *start,
                          const double *controls, double *derivative)
{
    const double *none = s->none;
    core_tangent_set(t, TANGENT_Q, start, none);
    core_tangent_set(t, TANGENT_QD, start + s->n, none);
    core_tangent_set(t, TANGENT_STATES, start + 2 * s->n, none);
    core_tangent_set(t, TANGENT_COMMANDS, controls, none);
    core_tangent_set(t, TANGENT_TORQUES, controls + s->m, none);
    if (core_tangent_move(t) || core_tangent_runge_kutta(t, h, steps)) return 1;
    core_tangent_changes(t, TANGENT_Q, derivative);
    core_tangent_changes(t, TANGENT_QD, derivative + s->n);
    core_tangent_changes(t, TANGENT_STATES, derivative + 2 * s->n);
    return 0;
}

int core_shooting_along(core_shooting *s, int32_t count, int32_t steps, const double *h, const double *starts,
                        const double *controls, const double *robot_changes, double *derivatives)
{
    core_tangent *t = rate_jacobian_tangent(s->rates);
    int bad = 0;
    core_tangent_change_robot(t, robot_changes);
    for (int32_t k = 0; k < count && !bad; k++) {
        const size_t row = (size_t)k * s->width;
        const double *own = controls + (size_t)k * (s->m + s->n);
        if (simulate_along(t, steps, h[k], s, starts + row, own, derivatives + row)) bad = 1 + k;
    }
    core_tangent_change_robot(t, s->none);
    return bad;
}

#else

size_t core_shooting_size(const core *plain)
{
    (void)plain;
    return 0;
}

core_shooting *core_shooting_open(core *plain, void *memory)
{
    (void)plain, (void)memory;
    return NULL;
}

int core_shooting_run(core_shooting *s, int32_t count, int32_t steps, const double *h, const double *starts,
                      const double *controls, int32_t directions, const int32_t *inputs, double *ends,
                      double *derivatives)
{
    (void)s, (void)count, (void)steps, (void)h, (void)starts, (void)controls, (void)directions, (void)inputs;
    (void)ends, (void)derivatives;
    return 1;
}

int core_shooting_along(core_shooting *s, int32_t count, int32_t steps, const double *h, const double *starts,
                        const double *controls, const double *robot_changes, double *derivatives)
{
    (void)s, (void)count, (void)steps, (void)h, (void)starts, (void)controls, (void)robot_changes, (void)derivatives;
    return 1;
}

#endif
