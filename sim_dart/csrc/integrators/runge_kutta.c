/* Steps of the plant by Runge-Kutta methods. All terms are explicit and evaluated at all four stages, except
   for fibres with elastic tendons, which are stiff. A joint that passes its limit is set to the limit at the
   end of the step, and stopped. */
#include "../dynamics/limits.h"
#include "../laws/laws.h"
#include "../laws/muscle_law.h"
#include "../loops/loops.h"
#include "runge_kutta.h"
#include "state_rates.h"

#include <string.h>

/* The classical method of order four. */
static const stage_table CLASSICAL = {
    {{0}, {0.5}, {0, 0.5}, {0, 0, 1}, {1 / 6.0, 2 / 6.0, 2 / 6.0, 1 / 6.0}}, {{0}}};

/* Order three, and L-stable for fibres: Ascher, Ruuth & Spiteri 1997, Appl. Numer. Math. 25, section 2.7. */
#define SHARE 0.435866521508459
#define WEIGHTS {0, 1.20849664917601, -0.644363170684469, SHARE}
static const stage_table IMPLICIT_FIBRES = {{{0},
                                             {SHARE},
                                             {0.32127888602862775, 0.3966543747256017},
                                             {-0.10585829607187965, 0.5529291480359398, 0.5529291480359398},
                                             WEIGHTS},
                                            {{0}, {0, SHARE}, {0, 0.2820667392457705, SHARE}, WEIGHTS, WEIGHTS}};

const stage_table *runge_kutta_stages(const core *c, real h)
{
    return c->has_fibres && value_of(h) > 0 ? &IMPLICIT_FIBRES : &CLASSICAL;
}

void runge_kutta_store(const core *c, const real *q, const real *qd, const real *states, real *to)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    memcpy(to, q, dofs * sizeof(real));
    memcpy(to + dofs, qd, dofs * sizeof(real));
    memcpy(to + 2 * dofs, states, (size_t)c->blob.law_states * sizeof(real));
}

/* Return number k of the state before the step + h times weighted rates of the stages. */
static real after(const core *c, size_t k, const constant weights[4], int stages, real h)
{
    const size_t numbers = state_size(c);
    real sum = 0;
    for (int i = 0; i < stages; i++)
        if (weights[i] != 0) sum += weights[i] * c->stage_rates[(size_t)i * numbers + k];
    return c->before[k] + h * sum;
}

/* Move fibres to the force equilibrium of an implicit stage. */
static void settle_fibres(core *c, const constant weights[4], int stage, real h)
{
    muscle_law at;
    for EACH_MUSCLE (c, &at) {
        if (!has_fibre(&at)) continue;
        const size_t k = 2 * (size_t)c->blob.counts.dofs + (size_t)(at.x + 1 - c->law_states);
        const real from = at.x[1] = after(c, k, weights, stage, h), time = weights[stage] * h;
        at.law->settle(at.k, at.x, length_at(c, at.m), time);
        at.xd[1] = (at.x[1] - from) / time;
    }
}

/* Move to a stage, or to the end of the step after four of them. Return the same as core_step. */
static int move_to(core *c, const stage_table *table, int stage, real h)
{
    const size_t dofs = (size_t)c->blob.counts.dofs, states = (size_t)c->blob.law_states;
    const constant *weights = table->explicit_weights[stage];
    for (size_t j = 0; j < dofs; j++) c->q[j] = after(c, j, weights, stage, h);
    for (size_t j = 0; j < dofs; j++) c->qd[j] = after(c, dofs + j, weights, stage, h);
    for (size_t k = 0; k < states; k++) c->law_states[k] = after(c, 2 * dofs + k, weights, stage, h);
    const int bad = muscles_are_sound(c) ? core_move_checked(c, c->q, c->qd) : (int)dofs + 1;
    if (!bad && stage < 4 && table->implicit_weights[stage][stage] != 0)
        settle_fibres(c, table->implicit_weights[stage], stage, h);
    return bad;
}

static int one_step(core *c, const real *u, const real *extra, real h, stage_observer *observe, void *observer)
{
    const stage_table *table = runge_kutta_stages(c, h);
    const size_t numbers = state_size(c);
    runge_kutta_store(c, c->q, c->qd, c->law_states, c->before);
    c->is_settling = table == &IMPLICIT_FIBRES;
    for (int stage = 0; stage < 4; stage++) {
        const int wrong = state_rates_evaluate(c, u, extra);
        if (wrong) return -wrong;
        runge_kutta_store(c, c->qd, c->qdd, c->law_rates, c->stage_rates + (size_t)stage * numbers);
        state_rates_add_work(c, table->explicit_weights[4][stage] * h);
        if (observe) observe(observer, stage, h);
        const int bad = move_to(c, table, stage + 1, h);
        if (bad) return bad;
    }
    if (c->blob.counts.closures) {
        if (observe) observe(observer, 4, h);
        loops_close(c);
    }
    limits_stop(c);
    return 0;
}

int runge_kutta_observed(core *c, const real *u, const real *extra, real h, int32_t steps, stage_observer *observe,
                         void *observer)
{
    int bad = 0;
    memset(c->work, 0, 4 * sizeof(real));
    for (; steps > 0 && !bad; steps--) bad = one_step(c, u, extra, h, observe, observer);
    c->is_settling = 0;
    return bad;
}

int core_runge_kutta(core *c, const real *u, const real *extra, real h, int32_t steps)
{
    return runge_kutta_observed(c, u, extra, h, steps, NULL, NULL);
}
