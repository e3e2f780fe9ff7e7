/* Disturbance observer: a load w on the left side of the motion equation, by a first-order filter

     w += gain (w_seen - w),   gain = 1 - exp(-bandwidth T),
     w_seen = -L'f - h - M (qd - qd_last)/T - w_e,   at the last tick

   With `midpoint`, L, h and M are those in the middle between both ticks, and gain = bandwidth T, at most 1: for a load
   that changes at a constant rate, w is then 1/bandwidth older than the load in the middle of the coming tick. */
#include "observer.h"

/* Compute L, h and M for the load. */
static void observed_terms(control_loop *s, const real *q, const real *qd)
{
    if (s->midpoint[0] == 0) {
        loop_terms(s, s->seen_q, s->seen_qd);
        return;
    }
    for (size_t j = 0; j < s->law->n; j++) {
        s->later[j] = (s->seen_q[j] + q[j]) / 2;
        s->faster[j] = (s->seen_qd[j] + qd[j]) / 2;
    }
    loop_terms(s, s->later, s->faster);
}

void loop_observe(control_loop *s, real period, const real *q, const real *qd)
{
    const computed_torque *law = s->law;
    const size_t n = law->n;
    if (!s->has_seen[0]) return;
    observed_terms(s, q, qd);
    for (size_t j = 0; j < n; j++) s->qdd[j] = (qd[j] - s->seen_qd[j]) / period;
    for (size_t j = 0; j < n; j++) {
        if (s->robot.dependent && s->robot.dependent[j] != 0) continue; /* acts on the others */
        real seen = -law->h[j] - dot(n, law->M + j * n, s->qdd) - s->seen_load[j];
        for (size_t i = 0; i < law->m; i++) seen -= law->L[i * n + j] * s->seen_forces[i];
        s->disturbance[j] += s->gain[0] * (seen - s->disturbance[j]);
    }
}
