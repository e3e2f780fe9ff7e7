"""Controllers of the native laws with a formula for the joint torque; see `JOINT_LAWS`."""

from __future__ import annotations

from .joint_space import JointSpaceController


class ForcePositionController(JointSpaceController):
    """Computed-torque controller without the acceleration of the reference.

    tau = M(q)(Kp (q_d - q) + Kd (qd_d - qd)) + C(q, qd) + G(q)

    Use this law for targets without an acceleration, such as the positions of a slider. The class
    of this name in kindyn controls each joint separately with M_jj. This law uses the full M, so
    that the motion of one joint does not disturb the others. The arguments, attributes and units
    are those of `JointSpaceController`.
    """

    law = "force_position"


class TorquePositionController(JointSpaceController):
    """Controller that emulates a spring and a damper at every joint.

    tau = Kp (q_d - q) - Kd qd

    The law follows the class of this name in kindyn. It requires no robot model except the muscle
    Jacobian. The joints sag by G/Kp under gravity. The arguments and attributes are those of
    `JointSpaceController`, but the gains have other units: kp in [N·m/rad] and kd in [N·m·s/rad],
    or [N/m] and [N·s/m] for prismatic joints.
    """

    law = "torque_position"


class LyapunovController(JointSpaceController):
    """Lyapunov static compensation: a spring and a damper at every joint, plus gravity.

    tau = G(q) + Kp (q_d - q) + Kd (qd_d - qd)

    For a constant reference, V = 1/2 qd'M qd + 1/2 e'Kp e decreases with V' = -qd'(Kd + D) qd. The
    robot therefore converges to q_d for every M. This holds for short sampling periods and for
    forces within their limits. The law corresponds to `LyapunovStaticCompensation` of CASPR, after
    A. B. Alp and S. K. Agrawal, Cable Suspended Robots: Design, Planning and Control, ICRA 2002.
    The arguments, attributes and units are those of `TorquePositionController`.
    """

    law = "lyapunov"
