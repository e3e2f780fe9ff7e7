/* Steps of the plant by the fourth-order Runge-Kutta method: all terms are explicit and evaluated at all
   four stages. A joint that passes its limit is set to the limit at the end of the step, and stopped. */
#include "../dynamics/limits.h"
#include "../laws/laws.h"
#include "../loops/loops.h"
#include "runge_kutta.h"
#include "state_rates.h"

#include <string.h>

static void begin_step(core *c)
{
    const size_t dofs = (size_t)c->blob.counts.dofs, states = (size_t)c->blob.law_states;
    memcpy(c->before, c->q, dofs * sizeof(real));
    memcpy(c->before + dofs, c->qd, dofs * sizeof(real));
    memcpy(c->before + 2 * dofs, c->law_states, states * sizeof(real));
    memset(c->slopes, 0, (2 * dofs + states) * sizeof(real));
}

/* Add weight * rates to slopes, and the work of this share of the step. */
static void add_stage(core *c, real weight, real h)
{
    const int32_t dofs = c->blob.counts.dofs, states = c->blob.law_states;
    for (int32_t j = 0; j < dofs; j++) {
        c->slopes[j] += weight * c->qd[j];
        c->slopes[dofs + j] += weight * c->qdd[j];
    }
    for (int32_t k = 0; k < states; k++) c->slopes[2 * dofs + k] += weight * c->law_rates[k];
    state_rates_add_work(c, weight * h / 6);
}

/* Move to before + h rates. Return the same as core_step. */
static int move_to(core *c, real h, const real *q_rates, const real *qd_rates, const real *x_rates)
{
    const int32_t dofs = c->blob.counts.dofs, states = c->blob.law_states;
    for (int32_t j = 0; j < dofs; j++) c->q[j] = c->before[j] + h * q_rates[j]; /* q_rates may be qd itself */
    for (int32_t j = 0; j < dofs; j++) c->qd[j] = c->before[dofs + j] + h * qd_rates[j];
    for (int32_t k = 0; k < states; k++) c->law_states[k] = c->before[2 * dofs + k] + h * x_rates[k];
    return muscles_are_sound(c) ? core_move_checked(c, c->q, c->qd) : dofs + 1;
}

static int one_step(core *c, const real *u, const real *extra, real h, stage_observer *observe, void *observer)
{
    static const real weights[4] = {1, 2, 2, 1}, shares[3] = {0.5, 0.5, 1};
    const int32_t dofs = c->blob.counts.dofs;
    begin_step(c);
    for (int stage = 0; stage < 4; stage++) {
        const int wrong = state_rates_evaluate(c, u, extra);
        if (wrong) return -wrong;
        add_stage(c, weights[stage], h);
        if (observe) observe(observer, stage, h);
        const int bad = stage < 3 ? move_to(c, shares[stage] * h, c->qd, c->qdd, c->law_rates)
                                  : move_to(c, h / 6, c->slopes, c->slopes + dofs, c->slopes + 2 * dofs);
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
    memset(c->work, 0, 4 * sizeof(real));
    for (; steps > 0; steps--) {
        const int bad = one_step(c, u, extra, h, observe, observer);
        if (bad) return bad;
    }
    return 0;
}

int core_runge_kutta(core *c, const real *u, const real *extra, real h, int32_t steps)
{
    return runge_kutta_observed(c, u, extra, h, steps, NULL, NULL);
}
