"""Torque-position control, after kindyn's `TorquePositionController`.

    tau = Kp (q_d - q) - Kd qd,   distributed over the muscles

A spring and a damper at every joint, with no model of the robot but its muscle Jacobian. The joints
sag by G/Kp under their weight. A model can be given to it in two ways that this package has apart:
`LyapunovController` holds the weight, `ForcePositionController` shapes the motion by M as well.
"""

from __future__ import annotations

from controllers.arrays import FloatArray

from .joint_space import JointSpaceController


class TorquePositionController(JointSpaceController):
    """A spring and a damper at every joint, made by muscles.

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
            qd_d: Not used: the damper is fixed to the ground.
            qdd_d: Not used.
            w_e: Generalised external load to make up for, shape (n,); none when None.
            correction: Added to the torque, shape (n,), in [N·m] or [N]; none when None.
        """
        tau: FloatArray = self.kp * self.error(q, q_d) - self.kd * qd
        if correction is not None:
            tau = tau + correction
        return tau if w_e is None else tau + w_e
