/* Disturbance observer: a load w on the left side of the motion equation, by a first-order filter

     w += gain (w_seen - w),   gain = 1 - exp(-bandwidth T),
     w_seen = -L'f - h - M (qd - qd_last)/T - w_e,   at the last tick */
#include "observer.h"

void loop_observe(control_loop *s, real period, const real *qd)
{
    const computed_torque *law = s->law;
    const size_t n = law->n;
    if (!s->has_seen[0]) return;
    loop_terms(s, s->seen_q, s->seen_qd);
    for (size_t j = 0; j < n; j++) s->qdd[j] = (qd[j] - s->seen_qd[j]) / period;
    for (size_t j = 0; j < n; j++) {
        if (s->robot.dependent && s->robot.dependent[j] != 0) continue; /* acts on the others */
        real seen = -law->h[j] - dot(n, law->M + j * n, s->qdd) - s->seen_load[j];
        for (size_t i = 0; i < law->m; i++) seen -= law->L[i * n + j] * s->seen_forces[i];
        s->disturbance[j] += s->gain[0] * (seen - s->disturbance[j]);
    }
}
