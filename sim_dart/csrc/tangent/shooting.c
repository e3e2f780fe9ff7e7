#include "shooting.h"

#include "rate_jacobian.h"

#include <string.h>

#if HAS_CORE_TANGENT

#include "../blob/state.h"
#include "../integrators/runge_kutta.h"
#include "../laws/hill/activation.h"
#include "../laws/muscle_law.h"

struct core_shooting {
    core *plain;
    rate_jacobian *rates;
    size_t n, m, width, across; /* width: numbers in a state; across: number of directions */
    const int32_t *inputs;
    const double *controls;        /* of the interval */
    double *start, *at, *slopes; /* derivatives of a state, or of its rates at each stage: width x across */
    double *none;                     /* zeros, as many as the blob has numbers or any array */
};

/* Return the maximum number of derivatives of a state. */
static size_t derivatives_of(const core *plain)
{
    const size_t controls = (size_t)plain->blob.counts.muscles + (size_t)plain->blob.counts.dofs;
    return state_size(plain) * (state_size(plain) + controls + 1);
}

/* Return an upper bound of the length of `none`. */
static size_t zeros_of(const core *plain)
{
    return core_tangent_robot_numbers(plain) + state_size(plain) + (size_t)plain->blob.counts.muscles;
}

size_t core_shooting_size(const core *plain)
{
    if (plain->blob.counts.bends) return 0;
    const size_t numbers = 5 * derivatives_of(plain) + zeros_of(plain);
    return sizeof(core_shooting) + numbers * sizeof(double) + rate_jacobian_size(plain);
}

core_shooting *core_shooting_open(core *plain, void *memory)
{
    core_shooting *s = memory;
    const size_t length = derivatives_of(plain);
    s->plain = plain;
    s->n = (size_t)plain->blob.counts.dofs, s->m = (size_t)plain->blob.counts.muscles;
    s->width = state_size(plain);
    s->at = (double *)(void *)(s + 1);
    s->slopes = s->at + length;
    s->none = s->slopes + 4 * length;
    memset(s->none, 0, zeros_of(plain) * sizeof(double));
    s->rates = rate_jacobian_open(plain, s->none + zeros_of(plain));
    return s;
}

/* Compute to += scale * slope. */
static void add(size_t count, double scale, const double *restrict slope, double *restrict to)
{
    for (size_t k = 0; k < count; k++) to[k] += scale * slope[k];
}

/* Add the derivatives of the rates of a stage, from those of its state. */
static void multiply(const core_shooting *s, const double *jacobian, double *slope)
{
    const size_t columns = s->width + s->m + s->n;
    for (size_t i = 0; i < s->width; i++) {
        double *row = slope + i * s->across;
        const double *jacobian_row = jacobian + i * columns;
        for (size_t k = 0; k < s->width; k++)
            if (jacobian_row[k] != 0) add(s->across, jacobian_row[k], s->at + k * s->across, row);
        for (size_t j = 0; j < s->across; j++) {
            const size_t input = (size_t)s->inputs[j];
            if (input >= s->width && input < columns) row[j] += jacobian_row[input];
        }
    }
}

/* Add a multiple of the derivative of h to a row. */
static void add_duration(const core_shooting *s, double scale, double *row)
{
    for (size_t j = 0; j < s->across; j++)
        if ((size_t)s->inputs[j] == s->width + s->m + s->n) row[j] += scale;
}

/* Compute row i of the derivatives of a state after h times weighted rates of the first stages. */
static void sum_row(const core_shooting *s, size_t i, const double weights[4], int stages, double h, double *row)
{
    if (row != s->start + i * s->across) memcpy(row, s->start + i * s->across, s->across * sizeof(double));
    for (int k = 0; k < stages; k++) {
        if (weights[k] == 0) continue;
        if (h != 0) add(s->across, weights[k] * h, s->slopes + ((size_t)k * s->width + i) * s->across, row);
        add_duration(s, weights[k] * s->plain->stage_rates[(size_t)k * s->width + i], row);
    }
}

/* Compute the derivatives of settled fibres, as in rows of the state, and of their rates: by the force
   equilibrium of each. See core_fibres for the numbers of the law. */
static void settle_fibres(const core_shooting *s, const double weights[4], int stage, double h)
{
    const core *c = s->plain;
    const double time = weights[stage] * h;
    muscle_law at;
    for EACH_MUSCLE (c, &at) {
        if (!has_fibre(&at)) continue;
        const size_t first = 2 * s->n + (size_t)(at.x - c->law_states), rate_row = (size_t)stage * s->width + first + 1;
        double *row = s->at + (first + 1) * s->across, *slope = s->slopes + rate_row * s->across;
        const double a = hill_activation(at.k, at.x[0]), rate = at.xd[1];
        const double point[FIBRE_POINT] = {a, at.x[1], rate, c->lengths[at.m], 0};
        double fibre[FIBRE_VALUES];
        at.law->fibre(at.k, point, fibre);
        const double by_fibre = fibre[2] + fibre[3] / time - fibre[5];
        const int is_held = at.x[1] <= at.k[HILL_MIN_FIBRE];
        const double per = is_held ? 0 : 1 / by_fibre, by_activation = at.x[0] < at.k[HILL_MIN_ACTIVATION] ? 0 : fibre[1];
        sum_row(s, first + 1, weights, stage, h, row);
        for (size_t j = 0; j < s->across; j++) slope[j] = -row[j], row[j] *= per * fibre[3] / time;
        add_duration(s, per * fibre[3] * rate / time * weights[stage], row);
        add(s->across, -per * by_activation, s->at + first * s->across, row);
        for (size_t i = 0; i < s->n; i++)
            if (c->jacobian[at.m * s->n + i] != 0)
                add(s->across, -per * fibre[5] * fibre[9] * c->jacobian[at.m * s->n + i], s->at + i * s->across, row);
        add(s->across, 1, row, slope);
        for (size_t j = 0; j < s->across; j++) slope[j] /= time;
        add_duration(s, -rate / h, slope);
    }
}

/* Multiply the derivatives of q and qd by those of loops_close. */
static void close_loops(const core_shooting *s)
{
    const double *jacobian = rate_jacobian_close(s->rates);
    const size_t rows = 2 * s->n;
    memset(s->at, 0, rows * s->across * sizeof(double));
    for (size_t i = 0; i < rows; i++)
        for (size_t k = 0; k < rows; k++) {
            double *row = s->at + i * s->across;
            add(s->across, jacobian[i * rows + k], s->start + k * s->across, row);
        }
    memcpy(s->start, s->at, rows * s->across * sizeof(double));
}

/* A stage_observer: advance the derivatives like the state. */
static void follow(void *self, int stage, double h)
{
    core_shooting *s = self;
    if (stage == 4) {
        close_loops(s);
        return;
    }
    const stage_table *table = runge_kutta_stages(s->plain, h);
    for (size_t i = 0; i < s->width; i++)
        sum_row(s, i, table->explicit_weights[stage], stage, h, s->at + i * s->across);
    double *slope = s->slopes + (size_t)stage * s->width * s->across;
    memset(slope, 0, s->width * s->across * sizeof(double));
    if (h != 0) {
        if (table->implicit_weights[stage][stage] != 0) settle_fibres(s, table->implicit_weights[stage], stage, h);
        multiply(s, rate_jacobian_fill(s->rates, s->controls, s->controls + s->m), slope);
    }
    if (stage < 3) return;
    for (size_t i = 0; i < s->width; i++)
        sum_row(s, i, table->explicit_weights[4], 4, h, s->start + i * s->across);
}

/* Set the derivatives at the start: 1 for the states among the inputs. */
static void begin(core_shooting *s, double *derivatives)
{
    s->start = derivatives;
    memset(derivatives, 0, s->width * s->across * sizeof(double));
    for (size_t j = 0; j < s->across; j++)
        if ((size_t)s->inputs[j] < s->width) derivatives[(size_t)s->inputs[j] * s->across + j] = 1;
}

/* Move to a state. Return nonzero if it is not finite. */
static int move_to(const core_shooting *s, const double *state)
{
    core *c = s->plain;
    memcpy(c->q, state, s->n * sizeof(double));
    memcpy(c->qd, state + s->n, s->n * sizeof(double));
    memcpy(c->law_states, state + 2 * s->n, (s->width - 2 * s->n) * sizeof(double));
    return core_move_checked(c, c->q, c->qd);
}

/* Simulate an interval. */
static int simulate(core_shooting *s, int32_t steps, double h, const double *start, double *end)
{
    core *c = s->plain;
    if (move_to(s, start)) return 1;
    if (runge_kutta_observed(c, s->controls, s->controls + s->m, h, steps, s->across ? follow : NULL, s)) return 1;
    runge_kutta_store(c, c->q, c->qd, c->law_states, end);
    return 0;
}

int core_shooting_run(core_shooting *s, int32_t count, const int32_t *steps, const double *h, const double *starts,
                      const double *controls, int32_t directions, const int32_t *inputs, double *ends,
                      double *derivatives)
{
    s->across = (size_t)directions, s->inputs = inputs;
    for (int32_t k = 0; k < count; k++) {
        s->controls = controls + (size_t)k * (s->m + s->n);
        if (s->across) begin(s, derivatives + (size_t)k * s->width * s->across);
        if (simulate(s, steps[k], h[k], starts + (size_t)k * s->width, ends + (size_t)k * s->width)) return 1 + k;
    }
    return 0;
}

int core_shooting_rates(core_shooting *s, int32_t count, const double *states, const double *controls, double *rates,
                        double *tensions)
{
    core *c = s->plain;
    for (int32_t k = 0; k < count; k++) {
        const double *u = controls + (size_t)k * (s->m + s->n);
        if (move_to(s, states + (size_t)k * s->width)) return 1 + k;
        if (!c->has_laws && core_drive(c, c->qd, u)) return 1 + k; /* core_derivative then needs no tensions */
        if (core_derivative(c, u, u + s->m)) return 1 + k;
        runge_kutta_store(c, c->qd, c->qdd, c->law_rates, rates + (size_t)k * s->width);
        memcpy(tensions + (size_t)k * s->m, c->tensions, s->m * sizeof(double));
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

int core_shooting_along(core_shooting *s, int32_t count, const int32_t *steps, const double *h, const double *starts,
                        const double *controls, const double *robot_changes, double *derivatives)
{
    core_tangent *t = rate_jacobian_tangent(s->rates);
    int bad = 0;
    core_tangent_change_robot(t, robot_changes);
    for (int32_t k = 0; k < count && !bad; k++) {
        const size_t row = (size_t)k * s->width;
        const double *u = controls + (size_t)k * (s->m + s->n);
        if (simulate_along(t, steps[k], h[k], s, starts + row, u, derivatives + row)) bad = 1 + k;
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

int core_shooting_run(core_shooting *s, int32_t count, const int32_t *steps, const double *h, const double *starts,
                      const double *controls, int32_t directions, const int32_t *inputs, double *ends,
                      double *derivatives)
{
    (void)s, (void)count, (void)steps, (void)h, (void)starts, (void)controls, (void)directions, (void)inputs;
    (void)ends, (void)derivatives;
    return 1;
}

#endif
