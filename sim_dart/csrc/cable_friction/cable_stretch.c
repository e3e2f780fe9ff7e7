/* Cables with friction that stretch along their path: elastic cables, winches and springs.

   A cable of compliance 1 / K has the total stretch e_0. The stretch e_k after bend k is W_k e_0, with W_k
   the share of the length after the bend, plus the stretch due to the tension differences F in the bends:

     e_k = W_k f / K + (C F)_k,      C_kj = (W_max(k,j) - W_k W_j) / K;

   f, computed from the total stretch, is the mean tension along the cable. The first span has T_1 = f / (1 +
   sum W_k (T_k+1 - T_k) / T_1). T_1 acts on motors and drums: the path length in their law is reduced by (f
   - T_1) / K.

   The unstretched length after bend k is l_k - e_k. Its decrease slides through the bend. So the sliding
   distance is

     dl_k - de_k,   within a step   h (A_k - W_k L) v - (C F)_k + (e_k - W_k f / K),

   where f grows by K h L v. e_k is a state with its value at the end of the last step, so that changes
   between steps, such as a new command or a drum that turns, are included. The torque on the joints is -L' f
   - sum (A_k - W_k L)' F_k, with the same rows. The stored energy is f^2 / 2 K + F' C F / 2; sliding creates
   no energy, as without stretch.

   C is the compliance of a chain of springs, the spans, fixed at both ends. The resistance of each bend is a
   further spring to the ground. The system is solved from the driven end. */
#include "cable_stretch.h"

#include "../math/elementary.h"

/* In [N/m]. */
static const real MIN_STIFFNESS = PRECISE(1e-6, 1e-3);

/* Return e_k of the cable with the bends `at`. In law_states, e_k of all stretching cables come before the
   states s. */
static real *stretches_of(const core *c, const bent_cable *at)
{
    real *state = c->law_states + c->blob.law_states - c->blob.counts.bends - c->blob.stretches;
    for (int32_t m = 0; m < at->muscle; m++) state += c->cable_stretches[m] != 0 ? c->blob.muscle_bends[m] : 0;
    return state;
}

void cable_stretch_take(core *c, int32_t muscle, int32_t bend, const cable_stretch *stretch)
{
    const bent_cable at = {muscle, bend, bend + c->blob.muscle_bends[muscle]};
    const real *slip = slips_of(c), *state = stretches_of(c, &at), total = c->lengths[muscle] + stretch->lead;
    const int is_taut = value_of(stretch->over) > 0 && value_of(total) > 0;
    const real per_total = is_taut ? 1 / total : 0;
    real rise = 0, T = 1;
    for (int32_t k = at.begin; k < at.end; k++) {
        const real W = c->bend_behind[k] * per_total, grown = T * exponential_less_one(c->bend_grip[k] * slip[k]);
        c->bend_share[k] = W;
        c->bend_owed[k] = *state++ - W * stretch->over;
        rise += W * grown, T += grown;
    }
    const real f = c->tensions[muscle];
    c->tensions[muscle] = f / (1 + rise);
    c->cable_rise[muscle] = rise, c->cable_stretches[muscle] = 1;
    c->cable_compliance[muscle] = is_taut ? 1 / larger(stretch->stiffness, MIN_STIFFNESS) : 0;
    c->cable_beyond[muscle] = (f - c->tensions[muscle]) * c->cable_compliance[muscle];
}

void cable_stretch_start(core *c)
{
    for EACH_CABLE (c, at) {
        if (c->cable_stretches[at.muscle] == 0) continue;
        real *state = stretches_of(c, &at);
        for (int32_t k = at.begin; k < at.end; k++, state++) *state -= c->bend_owed[k], c->bend_owed[k] = 0;
    }
}

void cable_stretch_advance(core *c, const bent_cable *at, real h)
{
    real *state = stretches_of(c, at);
    for (int32_t k = at->begin; k < at->end; k++)
        *state++ += h * c->bend_rates[k] - c->bend_presliding[k] * c->bend_next[k];
}

/* Return the compliance of the span after bend k. */
static real span_compliance(const core *c, const bent_cable *at, int32_t k)
{
    const real behind = k + 1 < at->end ? c->bend_share[k + 1] : 0;
    return c->cable_compliance[at->muscle] * larger(c->bend_share[k] - behind, 0);
}

void cable_stretch_yield(const core *c, const bent_cable *at, real *p)
{
    real soft = c->cable_compliance[at->muscle] * larger(1 - c->bend_share[at->begin], 0), moved = 0;
    for (int32_t k = at->begin; k < at->end; k++) {
        const real holds = 1 / (1 + soft * c->bend_slope[k] / c->bend_presliding[k]);
        moved = p[k] = (moved + soft * p[k]) * holds;
        c->bend_soft[k] = soft * holds;
        soft = c->bend_soft[k] + span_compliance(c, at, k);
    }
    for (int32_t k = at->end - 1; k >= at->begin; k--) {
        const real span = span_compliance(c, at, k), both = span + c->bend_soft[k];
        const real next = k + 1 < at->end ? p[k + 1] : 0;
        if (value_of(both) > 0) p[k] = (p[k] * span + c->bend_soft[k] * next) / both;
    }
}
