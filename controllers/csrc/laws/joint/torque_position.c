/* Torque-position control: a spring and a damper at every joint:

     tau = Kp (q_d - q) - Kd qd + correction + w_e

   As TorquePositionController in kindyn. */
#include "joint_laws.h"

void torque_position_torque(const computed_torque *s, real *tau)
{
    for (size_t j = 0; j < s->n; j++)
        tau[j] = s->kp[j] * s->error[j] - s->kd[j] * s->qd[j] + s->correction[j] + s->load[j];
}
