"""Force-position control, after kindyn's `ForcePositionController`.

    tau = M(q)(Kp (q_d - q) + Kd (qd_d - qd)) + C(q, qd) + G(q),   distributed over the muscles

It is computed torque without the reference's acceleration: for targets that come without one, such
as those of a person at a slider. kindyn controls each joint by itself with M_jj alone; here the
full M keeps one joint's motion from disturbing the others.

Computed by csrc/laws/joint/force_position.c.
"""

from __future__ import annotations

from .joint_space import JointSpaceController


class ForcePositionController(JointSpaceController):
    """Control of joint positions by forces, without the reference's acceleration.

    Arguments, attributes and units as of `JointSpaceController`.
    """

    law = "force_position"
