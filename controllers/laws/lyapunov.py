"""Lyapunov static compensation: a spring, a damper and the robot's weight.

    tau = G(q) + Kp (q_d - q) + Kd (qd_d - qd),   distributed over the muscles

At a reference at rest V = 1/2 qd'M qd + 1/2 e'Kp e only falls, V' = -qd'(Kd + D) qd: whatever M is,
the robot comes to rest at q_d. Sampled, that holds for short periods, and within the bounds of
forces. As CASPR's `LyapunovStaticCompensation`, after A. B. Alp and S. K. Agrawal, Cable Suspended
Robots: Design, Planning and Control, ICRA 2002.
"""

from __future__ import annotations

from controllers.arrays import FloatArray

from .joint_space import Instant, JointSpaceController, plus


class LyapunovController(JointSpaceController):
    """Control of joint positions that needs the robot's weight only.

    Arguments and attributes as of `JointSpaceController`, but for the units of the gains: kp in
    [N·m/rad], kd in [N·m·s/rad]; for prismatic joints [N/m], [N·s/m].
    """

    def _torque(self, now: Instant) -> FloatArray:
        q, qd, q_d, qd_d, _, correction = now
        tau = self.dynamics.gravity(q) + self.kp * self.error(q, q_d) + self.kd * (qd_d - qd)
        return plus(tau, correction)
