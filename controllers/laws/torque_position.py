"""Torque-position control, after kindyn's `TorquePositionController`.

    tau = Kp (q_d - q) - Kd qd,   distributed over the muscles

A spring and a damper at every joint, with no model of the robot but its muscle Jacobian. The joints
sag by G/Kp under their weight. A model can be given to it in two ways that this package has apart:
`LyapunovController` holds the weight, `ForcePositionController` shapes the motion by M as well.

Computed by csrc/laws/joint/torque_position.c.
"""

from __future__ import annotations

from .joint_space import JointSpaceController


class TorquePositionController(JointSpaceController):
    """A spring and a damper at every joint, made by muscles.

    Arguments and attributes as of `JointSpaceController`, but for the units of the gains: kp in
    [N·m/rad], kd in [N·m·s/rad]; for prismatic joints [N/m], [N·s/m].
    """

    law = "torque_position"
