"""Force-position control, after kindyn's `ForcePositionController`.

    tau = M(q)(Kp (q_d - q) + Kd (qd_d - qd)) + C(q, qd) + G(q),   distributed over the muscles

It is computed torque without the reference's acceleration: for targets that come without one, such
as those of a person at a slider. kindyn controls each joint by itself with M_jj alone; here the
full M keeps one joint's motion from disturbing the others.
"""

from __future__ import annotations

import numpy as np

from controllers.arrays import FloatArray

from .joint_space import JointSpaceController


class ForcePositionController(JointSpaceController):
    """Control of joint positions by forces, without the reference's acceleration.

    Arguments, attributes and units as of `JointSpaceController`.
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

        Arguments as of `JointSpaceController.required_torque`; qdd_d is not used.
        """
        none = np.zeros_like(qdd_d)
        return super().required_torque(q, qd, q_d, qd_d, none, w_e=w_e, correction=correction)
