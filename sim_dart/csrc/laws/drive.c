/* Tensions, torques and states of the muscles in a step. */
#include "laws.h"

#include "../cable_friction/cable_friction.h"
#include "../cable_friction/cable_stretch.h"
#include "../kinematics/joint_variables.h"
#include "../math/elementary.h"
#include "../paths/span.h"
#include "hill/activation.h"
#include "muscle_law.h"

#include <math.h>
#include <string.h>

/* Return 0, or 1 + the index of the first muscle whose command is not finite. */
static int find_bad_command(const core *c, const real *u)
{
    real sum = number(0); /* of zeros, or NaN */
    for (int32_t m = 0; m < c->blob.counts.muscles; m++) sum += 0 * u[m];
    if (!is_rare(c, sum != 0)) return 0;
    for (int32_t m = 0; m < c->blob.counts.muscles; m++)
        if (!all_of(isfinite(u[m])) && LAW_TABLE[c->blob.law_kind[m]].driven) return 1 + m;
    return 0;
}

void laws_place(core *c)
{
    muscle_law at;
    const real *point = c->point;
    for EACH_MUSCLE (c, &at) {
        if (at.law->place) {
            const real chord[3] = {point[3] - point[0], point[4] - point[1], point[5] - point[2]};
            at.law->place(at.k, chord, c->blob.gravity);
        }
        point += 3 * c->blob.muscle_points[at.m];
    }
}

void laws_weigh(const core *c, const real *u, real way, real *forces)
{
    muscle_law at;
    const real *g = c->blob.gravity, size = sqrt(dot3(g, g));
    int32_t k = 0;
    if (all_of(value_of(size) == 0)) return;
    for EACH_MUSCLE (c, &at) {
        if (at.law->weigh) {
            const real l = c->lengths[at.m];
            real down[2];
            at.law->weigh(at.k, l, u ? command(&at, u) : l, down);
            for (int end = 0; end < 2; end++) {
                const real share = at.scale * way * down[end] / size, *point = c->point + 3 * (k + end);
                const real pull[3] = {share * g[0], share * g[1], share * g[2]};
                span_add(c, pull, point, -1, point, c->blob.point_frame[k + end], forces);
            }
        }
        k += c->blob.muscle_points[at.m];
    }
}

/* Add the weight of heavy cables to torques. */
static void add_weights(core *c, const real *u)
{
    const size_t dofs = (size_t)c->blob.counts.dofs, variables = (size_t)c->blob.counts.variables;
    if (!c->is_driven) {
        laws_weigh(c, u, number(1), c->torques);
        return;
    }
    memset(c->row, 0, variables * sizeof(real));
    memcpy(c->row, c->torques, dofs * sizeof(real));
    laws_weigh(c, u, number(1), c->row);
    variables_fold(c, c->row, c->torques);
}

void core_rates(core *c, const real *qd)
{
    const int32_t dofs = c->blob.counts.dofs;
    for (int32_t m = 0; m < c->blob.counts.muscles; m++) {
        const real *row = c->jacobian + (size_t)m * (size_t)dofs;
        real rate = number(0);
        for (int32_t j = index_of(c->column_first[m]), end = index_of(c->column_end[m]); j < end; j++)
            rate += row[j] * qd[j];
        c->rates[m] = rate;
    }
    if (has_bends(c)) cable_friction_rates(c, qd);
}

/* Replace the mean tensions of cables that stretch along their path by the tensions at their driven ends. */
static void stretch_cables(core *c, const real *u)
{
    muscle_law at;
    int32_t bend = 0;
    for EACH_MUSCLE (c, &at) {
        if (does_stretch(c, at.m)) {
            const cable_stretch stretch = at.law->stretch(at.k, at.x, c->lengths[at.m], command(&at, u));
            cable_stretch_take(c, at.m, bend, &stretch);
        }
        bend += c->blob.muscle_bends[at.m];
    }
}

int core_start(core *c, const real *u)
{
    const int bad = find_bad_command(c, u);
    if (bad) return bad;
    muscle_law at;
    for EACH_MUSCLE (c, &at)
        if (at.states) at.law->start(at.k, c->lengths[at.m], command(&at, u), at.x);
    if (has_bends(c)) cable_friction_start(c);
    if (USES_CABLE_FRICTION && c->blob.stretches) {
        stretch_cables(c, u);
        cable_stretch_start(c);
    }
    return 0;
}

/* Add the torques of a muscle that pulls. */
static inline void add_pull(core *c, int32_t m, real pull)
{
    const real *row = c->jacobian + (size_t)m * (size_t)c->blob.counts.dofs;
    const int32_t end = index_of(c->column_end[m]);
    for (int32_t j = index_of(c->column_first[m]); j < end; j++) c->torques[j] -= row[j] * pull;
}

static void add_torques(core *c)
{
    const int32_t dofs = c->blob.counts.dofs;
    memset(c->torques, 0, (size_t)dofs * sizeof(real));
    for (int32_t m = 0; m < c->blob.counts.muscles; m++)
        if (any_of(c->tensions[m] != 0)) add_pull(c, m, c->tensions[m]);
    if (has_bends(c)) cable_friction_pull(c);
}

int core_pull(core *c, const real *f)
{
    const int32_t dofs = c->blob.counts.dofs, muscles = c->blob.counts.muscles;
    for (int32_t k = 0; k < muscles; k++)
        if (is_rare(c, isfinite(f[k]) == 0)) return 1 + k;
    memset(c->torques, 0, (size_t)dofs * sizeof(real));
    for (int32_t k = 0; k < muscles; k++) {
        const truth is_slack = (value_of(f[k]) < 0) | (f[k] == 0); /* a zero with a tangent is a pull: see tangent.h */
        if (all_of(is_slack)) continue;
        add_pull(c, k, choose(is_slack, number(0), c->tension_scale[k] * f[k]));
    }
    if (!has_bends(c)) return 0;
    for (int32_t k = 0; k < muscles; k++) c->tensions[k] = c->tension_scale[k] * larger(f[k], number(0));
    cable_friction_pull(c);
    return 0;
}

int core_drive(core *c, const real *qd, const real *u)
{
    const int bad = find_bad_command(c, u);
    if (bad) return bad;
    core_rates(c, qd);
    muscle_law at;
    for EACH_MUSCLE (c, &at)
        c->tensions[at.m] = bounded_tension(&at, at.x, c->lengths[at.m], c->rates[at.m], command(&at, u));
    if (USES_CABLE_FRICTION && c->blob.stretches) stretch_cables(c, u);
    add_torques(c);
    if (c->has_weight) add_weights(c, u);
    return 0;
}

int core_law_rates(core *c, const real *u)
{
    const int bad = find_bad_command(c, u);
    if (bad) return bad;
    muscle_law at;
    for EACH_MUSCLE (c, &at)
        if (c->is_settling && has_fibre(&at))
            at.xd[0] = activation_rate(at.k, at.x[0], command(&at, u));
        else if (at.states)
            at.law->rates(at.k, at.x, length_at(c, at.m), c->rates[at.m], command(&at, u), at.xd);
    if (has_bends(c)) cable_friction_state_rates(c);
    return 0;
}

int core_advance(core *c, const real *u, real h)
{
    const int bad = find_bad_command(c, u);
    if (bad) return bad;
    muscle_law at;
    activations active;
    active.count = 0;
    for EACH_MUSCLE (c, &at) {
        if (at.law->is_hill && at.states == 1) /* its activation only */
            activations_add(&active, at.k, at.x, command(&at, u), h);
        else if (at.states)
            at.law->advance(at.k, at.x, length_at(c, at.m), c->rates[at.m], command(&at, u), h);
    }
    if (active.count) activations_finish(&active, h);
    if (has_bends(c)) cable_friction_advance(c, h);
    return 0;
}

int muscles_pull(core *c, const real *u)
{
    return c->has_laws ? core_drive(c, c->qd, u) : core_pull(c, u);
}

int muscles_are_sound(const core *c)
{
    for (int32_t k = 0; k < c->blob.law_states; k++)
        if (is_rare(c, isfinite(c->law_states[k]) == 0)) return 0;
    return 1;
}
