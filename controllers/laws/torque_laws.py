"""Controllers of native laws that are a formula for the joints' torque: see `JOINT_LAWS`."""

from __future__ import annotations

from .joint_space import JointSpaceController


class ForcePositionController(JointSpaceController):
    """Computed torque without the reference's acceleration, after kindyn's class of this name.

    tau = M(q)(Kp (q_d - q) + Kd (qd_d - qd)) + C(q, qd) + G(q)

    For targets that come without an acceleration, such as those of a person at a slider. kindyn
    controls each joint by itself with M_jj alone; here the full M keeps one joint's motion from
    disturbing the others. Arguments, attributes and units as of `JointSpaceController`.
    """

    law = "force_position"


class TorquePositionController(JointSpaceController):
    """A spring and a damper at every joint, after kindyn's class of this name.

    tau = Kp (q_d - q) - Kd qd

    It needs no model of the robot but its muscle Jacobian; the joints sag by G/Kp under their
    weight. Arguments and attributes as of `JointSpaceController`, but for the units of the gains:
    kp in [N·m/rad], kd in [N·m·s/rad]; for prismatic joints [N/m], [N·s/m].
    """

    law = "torque_position"


class LyapunovController(JointSpaceController):
    """Lyapunov static compensation: a spring, a damper and the robot's weight.

    tau = G(q) + Kp (q_d - q) + Kd (qd_d - qd)

    At a reference at rest V = 1/2 qd'M qd + 1/2 e'Kp e only falls, V' = -qd'(Kd + D) qd: whatever M
    is, the robot comes to rest at q_d. Sampled, that holds for short periods, and within the bounds
    of forces. As CASPR's `LyapunovStaticCompensation`, after A. B. Alp and S. K. Agrawal, Cable
    Suspended Robots: Design, Planning and Control, ICRA 2002. Arguments, attributes and units of
    the gains as of `TorquePositionController`.
    """

    law = "lyapunov"
