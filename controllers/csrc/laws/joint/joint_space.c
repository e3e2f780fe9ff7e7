/* Computed torque: the left side of eq. (3), with joint damping and the known load:

     tau = M (qdd_d + correction + Kd (qd_d - qd) + Kp (q_d - q)) + C + G + D qd + w_e */
#include "../program.h"
#include "joint_laws.h"

void joint_space_torque(const computed_torque *s, real *tau)
{
    desired_acceleration(s, s->desired);
    for (size_t j = 0; j < s->n; j++)
        tau[j] = dot(s->n, s->M + j * s->n, s->desired) + (s->h[j] + s->load[j]);
}
