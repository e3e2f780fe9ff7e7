/* Capstan friction with presliding (Dahl).

   In bend k the tension grows from T on the driven side to T exp(E s) on the other side, E = mu theta. The
   state s, from -1 to 1, depends on the sliding distance dl_k = A_k dq and the presliding distance d:

     s+ = (s + x) / (1 + |x|),   x = dl_k / d,

   which is s' = (l_k' - s |l_k'|) / d, integrated by the implicit Euler method. T of the first bend is the
   muscle tension f at the first via point, the driven end. The torque on the joints is

     tau = -L' f - sum A_k' F_k,   F_k = T (exp(E s) - 1).

   For constant T and E this model is passive. The stored energy is V(s) = T d int_0^s (exp(E r) - 1) dr. A
   step with F_k at its end dissipates

     F_k(s+) dl_k - V(s+) + V(s)  >=  F_k(s+) d x s+  >=  0   (x > 0; x < 0 likewise),

   as exp is convex and s+ - s = x (1 - s+). Each bend needs a state. With a single state per cable, energy
   would be created when some spans compute_rates while others shorten.

   A step of the plant uses F_k at the end of the step: with v = qd + h qdd at the end, and x = h A_k v / d,

     M (v - qd) = h (tau_0 - sum A_k' F_k(x))

   has one solution, as F_k grows with x. It is found by Newton's method. The tangent of F_k(x) at x_k adds
   (h^2 / d) A_k' F_k' A_k to M. Starting from x = 0 on the side of the solution, the iterates approach it
   monotonically, as F_k is concave there for E <= 1; an iterate that changes sides restarts at 0 on the new
   side. After NEWTON_ROUNDS iterations, each step ends at the minimum, along its direction, of the convex
   function that the solution minimises: with P_k the force of the tangent, which defines M v, the slope of
   this function is sum d (F_k - P_k) dx_k. T is the tension at the start of the step. For cables that
   stretch along their path, see cable_stretch.c. */
#include "cable_friction.h"

#include "../math/elementary.h"
#include "cable_stretch.h"

#include <string.h>

#define NEWTON_ROUNDS 8
#define MAX_ROUNDS 60
#define FRICTION_HALVINGS 12
/* Tolerance of the friction in a bend in the last iteration, relative to the tensions on both sides. */
#define AGREEMENT PRECISE(1e-13, 1e-6)

static const real *flow_of(const core *c, int32_t k)
{
    return c->bend_flow + (size_t)k * (size_t)c->blob.counts.dofs;
}

static real sliding_rate(const core *c, int32_t k, const real *qd)
{
    const real *flow = flow_of(c, k);
    real rate = 0;
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) rate += flow[j] * qd[j];
    return rate;
}

static void add_force(core *c, int32_t k, real F)
{
    const real *flow = flow_of(c, k);
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) c->torques[j] -= flow[j] * F;
}

static real next_state(real s, real x)
{
    return (s + x) / (1 + fabs(x));
}

static real friction_at(const core *c, int32_t k, real s)
{
    return c->bend_tension[k] * exponential_less_one(c->bend_grip[k] * s);
}

static int is_stretched(const core *c, const bent_cable *at)
{
    return c->cable_compliance[at->muscle] != 0;
}

void cable_friction_pull(core *c)
{
    const real *slip = slips_of(c);
    for (int32_t m = 0, k = 0; m < c->blob.counts.muscles; m++) {
        real T = larger(c->tensions[m], 0);
        for (int32_t left = c->blob.muscle_bends[m]; left > 0; left--, k++) {
            c->bend_tension[k] = T;
            const real F = friction_at(c, k, slip[k]);
            add_force(c, k, F);
            T += F;
        }
        c->far_tensions[m] = T;
    }
}

/* ------------------------------------------------------------------------------ sliding in a step */

/* Compute the friction of a cable from the tangents at bend_way, for the rates bend_rates and rates of bends
   and cable: bend_next_pull and bend_next. */
static void pull_by_tangents(core *c, const bent_cable *at, real h)
{
    const real *d = c->bend_presliding, *share = c->bend_share, l = is_stretched(c, at) ? c->rates[at->muscle] : 0;
    for (int32_t k = at->begin; k < at->end; k++) {
        const real rate = c->bend_rates[k], x = h / d[k] * (rate - share[k] * l) + c->bend_owed[k] / d[k];
        c->bend_next[k] = x;
        c->bend_next_pull[k] = c->bend_lag[k] = c->bend_force[k] + c->bend_slope[k] * (x - c->bend_way[k]);
    }
    if (!is_stretched(c, at)) return;
    cable_stretch_yield(c, at, c->bend_lag);
    for (int32_t k = at->begin; k < at->end; k++) {
        c->bend_next[k] -= c->bend_lag[k] / d[k];
        c->bend_next_pull[k] -= c->bend_slope[k] * (c->bend_lag[k] / d[k]);
    }
}

static void take_tangents(core *c, real h)
{
    const real *slip = slips_of(c), *d = c->bend_presliding;
    for (int32_t k = 0; k < c->blob.counts.bends; k++) {
        const real x = c->bend_way[k], near = 1 + fabs(x), s = next_state(slip[k], x);
        const real F = friction_at(c, k, s), per_way = (1 - c->bend_side[k] * slip[k]) / (near * near);
        c->bend_force[k] = F;
        c->bend_slope[k] = (c->bend_tension[k] + F) * c->bend_grip[k] * per_way;
        c->bend_resistance[k] = h * h / d[k] * c->bend_slope[k];
    }
}

/* Compute the sliding distances for bend_rates and rates if friction stayed unchanged. */
static void begin_iterations(core *c, real h)
{
    const real *slip = slips_of(c);
    for (int32_t k = 0; k < c->blob.counts.bends; k++)
        c->bend_way[k] = c->bend_slope[k] = 0, c->bend_force[k] = friction_at(c, k, slip[k]);
    for EACH_CABLE (c, at) pull_by_tangents(c, &at, h);
    for (int32_t k = 0; k < c->blob.counts.bends; k++) {
        c->bend_way[k] = c->bend_next[k];
        c->bend_side[k] = value_of(c->bend_way[k]) < 0 ? -1 : 1;
    }
    c->friction_rounds = c->friction_settled = 0;
    take_tangents(c, h);
}

/* Return whether the tangents agree with the friction law at bend_next. */
static int has_converged(core *c, real h)
{
    const real *slip = slips_of(c);
    int agrees = 1;
    for EACH_CABLE (c, at) pull_by_tangents(c, &at, h);
    for (int32_t k = 0; k < c->blob.counts.bends; k++) {
        const real F = friction_at(c, k, next_state(slip[k], c->bend_next[k]));
        agrees &= value_of(fabs(F - c->bend_next_pull[k])) <= value_of(AGREEMENT * (c->bend_tension[k] + fabs(F)));
        c->bend_force[k] = F;
    }
    return agrees;
}

/* Start the next iteration at the end of this one, or at 0 if the sliding direction changes. */
static void start_newton_step(core *c)
{
    for (int32_t k = 0; k < c->blob.counts.bends; k++) {
        const int turns = value_of(c->bend_side[k] * c->bend_next[k]) < 0;
        c->bend_way[k] = turns ? 0 : c->bend_next[k];
        c->bend_pull[k] = c->bend_next_pull[k];
        if (turns) c->bend_side[k] = -c->bend_side[k];
    }
}

/* Return whether the minimum along the step lies before the fraction t from bend_way to bend_next, see
   above. */
static int is_minimum_before(const core *c, real t)
{
    const real *slip = slips_of(c);
    real slope = 0;
    for (int32_t k = 0; k < c->blob.counts.bends; k++) {
        const real dx = c->bend_next[k] - c->bend_way[k], F = friction_at(c, k, next_state(slip[k], c->bend_way[k] + t * dx));
        slope += c->bend_presliding[k] * (F - c->bend_pull[k] - t * (c->bend_next_pull[k] - c->bend_pull[k])) * dx;
    }
    return value_of(slope) > 0;
}

/* Start the next iteration at the minimum along the step from bend_way to bend_next. `is_whole`: at its end. */
static void start_at_minimum(core *c, int is_whole)
{
    real low = 0, high = 1, t = 1;
    for (int i = 0; i < FRICTION_HALVINGS && !is_whole; i++) {
        if (is_minimum_before(c, t)) high = t;
        else low = t;
        t = 0.5 * (low + high);
    }
    for (int32_t k = 0; k < c->blob.counts.bends; k++) {
        c->bend_way[k] += t * (c->bend_next[k] - c->bend_way[k]);
        c->bend_pull[k] += t * (c->bend_next_pull[k] - c->bend_pull[k]);
        c->bend_side[k] = value_of(c->bend_way[k]) < 0 ? -1 : 1;
    }
}

/* Return whether another iteration is needed: bend_force is not yet the friction at bend_next. If so,
   compute its tangents. */
static int needs_iteration(core *c, real h)
{
    const int32_t was = c->friction_rounds++, is_last = was >= MAX_ROUNDS;
    const int agrees = has_converged(c, h);
    /* derivatives need one more iteration */
    if ((agrees && (!HAS_TANGENT || c->friction_settled)) || is_last) return 0;
    c->friction_settled = agrees;
    if (was < NEWTON_ROUNDS) start_newton_step(c);
    else start_at_minimum(c, agrees || was == NEWTON_ROUNDS);
    take_tangents(c, h);
    return 1;
}

/* ------------------------------------------------------------------------------ velocities of a step */

void cable_friction_rates(core *c, const real *qd)
{
    for (int32_t k = 0; k < c->blob.counts.bends; k++) c->bend_rates[k] = sliding_rate(c, k, qd);
}

/* Compute bend_rates and rates at the current velocities. */
static void compute_rates(core *c)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    cable_friction_rates(c, c->qd);
    for EACH_CABLE (c, at) {
        const real *L = c->jacobian + (size_t)at.muscle * dofs;
        real rate = 0;
        for (size_t j = 0; j < dofs && is_stretched(c, &at); j++) rate += L[j] * c->qd[j];
        if (is_stretched(c, &at)) c->rates[at.muscle] = rate;
    }
}

/* Add the torques of the tension differences F in the bends. */
static void add_friction(core *c, const real *F, real times)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    for EACH_CABLE (c, at) {
        const real *L = c->jacobian + (size_t)at.muscle * dofs;
        real mean = 0;
        for (int32_t k = at.begin; k < at.end; k++) add_force(c, k, times * F[k]), mean += times * c->bend_share[k] * F[k];
        for (size_t j = 0; j < dofs && is_stretched(c, &at); j++) c->torques[j] += L[j] * mean;
    }
}

/* Compute the friction from the tangents at the velocities at the start of the step, for the next iteration. */
static void pull_for_iteration(core *c, real h)
{
    memcpy(c->torques, c->torques_before, (size_t)c->blob.counts.dofs * sizeof(real));
    for EACH_CABLE (c, at) pull_by_tangents(c, &at, h);
    add_friction(c, c->bend_next_pull, 1);
}

/* Compute the torques without friction and the sliding distances at the current velocities. */
void cable_friction_begin(core *c, real h)
{
    const real *slip = slips_of(c);
    for (int32_t k = 0; k < c->blob.counts.bends; k++) c->bend_force[k] = friction_at(c, k, slip[k]);
    add_friction(c, c->bend_force, -1);
    memcpy(c->torques_before, c->torques, (size_t)c->blob.counts.dofs * sizeof(real));
    c->is_rubbing = 1;
    compute_rates(c);
    begin_iterations(c, h);
    pull_for_iteration(c, h);
}

int cable_friction_has_converged(core *c, real h)
{
    compute_rates(c);
    if (!needs_iteration(c, h)) {
        memcpy(c->torques, c->torques_before, (size_t)c->blob.counts.dofs * sizeof(real));
        add_friction(c, c->bend_force, 1);
        c->is_rubbing = 0;
        return 1;
    }
    memcpy(c->qd, c->before, (size_t)c->blob.counts.dofs * sizeof(real));
    compute_rates(c);
    pull_for_iteration(c, h);
    return 0;
}

static void resist_rigid(const core *c, const bent_cable *at, real *M)
{
    const size_t n = (size_t)c->blob.counts.dofs;
    for (int32_t k = at->begin; k < at->end; k++) {
        const real *flow = flow_of(c, k);
        for (size_t i = 0; i < n; i++) {
            const real share = c->bend_resistance[k] * flow[i];
            for (size_t j = 0; share != 0 && j < n; j++) M[i * n + j] += share * flow[j];
        }
    }
}

/* Add the resistance of a cable that stretches, column by column. The compliance of the spans reduces it. */
static void resist_stretched(const core *c, const bent_cable *at, real *M)
{
    const size_t n = (size_t)c->blob.counts.dofs;
    const real *L = c->jacobian + (size_t)at->muscle * n, *share = c->bend_share;
    for (size_t j = 0; j < n; j++) {
        for (int32_t k = at->begin; k < at->end; k++) {
            const real slide = flow_of(c, k)[j] - share[k] * L[j];
            c->bend_lag[k] = c->bend_slope[k] / c->bend_presliding[k] * slide;
        }
        cable_stretch_yield(c, at, c->bend_lag);
        for (int32_t k = at->begin; k < at->end; k++) {
            const real *flow = flow_of(c, k), stuck = flow[j] - share[k] * L[j] - c->bend_lag[k];
            for (size_t i = 0; i < n; i++) M[i * n + j] += c->bend_resistance[k] * (flow[i] - share[k] * L[i]) * stuck;
        }
    }
}

void cable_friction_resist(const core *c, real *M)
{
    for EACH_CABLE (c, at) {
        if (is_stretched(c, &at)) resist_stretched(c, &at, M);
        else resist_rigid(c, &at, M);
    }
}

/* ------------------------------------------------------------------------------ states */

/* Return the energy that a bend dissipates, over T d; see above. */
static real dissipated_energy(real E, real s, real x, real next)
{
    const real begin = exponential_less_one(E * s), end = exponential_less_one(E * next);
    return value_of(E) > 0 ? end * x + (next - s) - (end - begin) / E : 0;
}

void cable_friction_state_rates(core *c)
{
    const real *slip = slips_of(c);
    real *rates = c->law_rates + (slip - c->law_states), *stretching = rates - c->blob.stretches;
    for EACH_CABLE (c, at)
        for (int32_t k = at.begin; k < at.end; k++) {
            const real by_stretch = is_stretched(c, &at) ? c->bend_share[k] * c->rates[at.muscle] : 0;
            const real rate = c->bend_rates[k] - by_stretch;
            rates[k] = (rate - slip[k] * fabs(rate)) / c->bend_presliding[k];
            if (c->cable_stretches[at.muscle] != 0) *stretching++ = by_stretch;
        }
}

void cable_friction_start(core *c)
{
    memset(slips_of(c), 0, (size_t)c->blob.counts.bends * sizeof(real));
}

/* Compute bend_next: the sliding distances of a step over the presliding distance. */
static void find_slips(core *c, real h)
{
    if (c->blob.stretches) {
        begin_iterations(c, h);
        while (needs_iteration(c, h)) continue;
        return;
    }
    for (int32_t k = 0; k < c->blob.counts.bends; k++) c->bend_next[k] = h / c->bend_presliding[k] * c->bend_rates[k];
}

void cable_friction_advance(core *c, real h)
{
    real *slip = slips_of(c);
    const real *d = c->bend_presliding;
    find_slips(c, h);
    for (int32_t k = 0; k < c->blob.counts.bends; k++) {
        const real x = c->bend_next[k], next = next_state(slip[k], x);
        const real lost = c->bend_tension[k] * d[k] * larger(dissipated_energy(c->bend_grip[k], slip[k], x, next), 0);
        c->work[0] += lost, c->work[3] -= lost; /* torques contain both */
        slip[k] = next;
    }
    for EACH_CABLE (c, at)
        if (c->cable_stretches[at.muscle] != 0) cable_stretch_advance(c, &at, h);
}

/* ------------------------------------------------------------------------------ for controllers */

void core_slide(core *c, const real *way)
{
    real *slip = slips_of(c);
    for (int32_t k = 0; k < c->blob.counts.bends; k++) slip[k] = next_state(slip[k], sliding_rate(c, k, way) / c->bend_presliding[k]);
}

void core_pulling(core *c)
{
    const real *slip = slips_of(c);
    const size_t dofs = (size_t)c->blob.counts.dofs;
    if (!c->blob.counts.bends) return;
    memcpy(c->pull_jacobian, c->jacobian, (size_t)c->blob.counts.muscles * dofs * sizeof(real));
    for (int32_t m = 0, k = 0; m < c->blob.counts.muscles; m++) {
        real *row = c->pull_jacobian + (size_t)m * dofs, share = 1;
        for (int32_t left = c->blob.muscle_bends[m]; left > 0; left--, k++) {
            const real grown = share * exponential_less_one(c->bend_grip[k] * slip[k]), *flow = flow_of(c, k);
            for (size_t j = 0; j < dofs; j++) row[j] += grown * flow[j];
            share += grown;
        }
    }
}
