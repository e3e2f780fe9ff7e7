/* Force-position control: computed torque without the acceleration of the reference:

     tau = M (Kp (q_d - q) + Kd (qd_d - qd) + correction) + C + G + D qd + w_e

   As ForcePositionController in kindyn, with the full M instead of M_jj. */
#include "joint_laws.h"

void force_position_torque(const computed_torque *s, real *tau)
{
    for (size_t j = 0; j < s->n; j++)
        s->desired[j] = s->correction[j] + s->kd[j] * s->rate_error[j] + s->kp[j] * s->error[j];
    for (size_t j = 0; j < s->n; j++)
        tau[j] = dot(s->n, s->M + j * s->n, s->desired) + (s->h[j] + s->load[j]);
}
