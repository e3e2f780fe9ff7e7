/* Lyapunov static compensation: a spring, a damper and gravity compensation:

     tau = G + Kp (q_d - q) + Kd (qd_d - qd) + correction + w_e

   A. B. Alp and S. K. Agrawal, Cable suspended robots: design, planning and control, ICRA 2002. */
#include "joint_laws.h"

void lyapunov_torque(const computed_torque *s, real *tau)
{
    for (size_t j = 0; j < s->n; j++)
        tau[j] = s->G[j] + s->kp[j] * s->error[j] + s->kd[j] * s->rate_error[j] + s->correction[j] + s->load[j];
}
