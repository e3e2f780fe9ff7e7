"""Torque-position control, after kindyn's `TorquePositionController`.

    tau = Kp (q_d - q) - Kd qd,   distributed over the muscles

A spring and a damper at every joint, with no model of the robot but its muscle Jacobian. The joints
sag by G/Kp under their weight. A model can be given to it in two ways that this package has apart:
`LyapunovController` holds the weight, `ForcePositionController` shapes the motion by M as well.
"""

from __future__ import annotations

from controllers.arrays import FloatArray

from .joint_space import Instant, JointSpaceController, plus


class TorquePositionController(JointSpaceController):
    """A spring and a damper at every joint, made by muscles.

    Arguments and attributes as of `JointSpaceController`, but for the units of the gains: kp in
    [N·m/rad], kd in [N·m·s/rad]; for prismatic joints [N/m], [N·s/m].
    """

    def _torque(self, now: Instant) -> FloatArray:
        q, qd, q_d, _, _, correction = now
        return plus(self.kp * self.error(q, q_d) - self.kd * qd, correction)
