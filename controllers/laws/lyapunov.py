"""Lyapunov static compensation: a spring, a damper and the robot's weight.

    tau = G(q) + Kp (q_d - q) + Kd (qd_d - qd),   distributed over the muscles

At a reference at rest V = 1/2 qd'M qd + 1/2 e'Kp e only falls, V' = -qd'(Kd + D) qd: whatever M is,
the robot comes to rest at q_d. Sampled, that holds for short periods, and within the bounds of
forces. As CASPR's `LyapunovStaticCompensation`, after A. B. Alp and S. K. Agrawal, Cable Suspended
Robots: Design, Planning and Control, ICRA 2002.
"""

from __future__ import annotations

from controllers.arrays import FloatArray

from .joint_space import JointSpaceController


class LyapunovController(JointSpaceController):
    """Control of joint positions that needs the robot's weight only.

    Arguments and attributes as of `JointSpaceController`, but for the units of the gains: kp in
    [N·m/rad], kd in [N·m·s/rad]; for prismatic joints [N/m], [N·s/m].
    """

    def required_torque(
        self,
        q: FloatArray,
        qd: FloatArray,
        q_d: FloatArray,
        qd_d: FloatArray,
        qdd_d: FloatArray,
        *,
        w_e: FloatArray | None = None,
        correction: FloatArray | None = None,
    ) -> FloatArray:
        """The torque that the muscles must make, shape (n,), in [N·m] or [N].

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            q_d: Desired positions, shape (n,).
            qd_d: Desired velocities, shape (n,).
            qdd_d: Not used.
            w_e: Generalised external load to make up for, shape (n,); none when None.
            correction: Added to the torque, shape (n,), in [N·m] or [N]; none when None.
        """
        tau: FloatArray = (
            self.dynamics.gravity(q) + self.kp * self.error(q, q_d) + self.kd * (qd_d - qd)
        )
        if correction is not None:
            tau = tau + correction
        return tau if w_e is None else tau + w_e
