"""Lyapunov static compensation: a spring, a damper and the robot's weight.

    tau = G(q) + Kp (q_d - q) + Kd (qd_d - qd),   distributed over the muscles

At a reference at rest V = 1/2 qd'M qd + 1/2 e'Kp e only falls, V' = -qd'(Kd + D) qd: whatever M is,
the robot comes to rest at q_d. Sampled, that holds for short periods, and within the bounds of
forces. As CASPR's `LyapunovStaticCompensation`, after A. B. Alp and S. K. Agrawal, Cable Suspended
Robots: Design, Planning and Control, ICRA 2002.

Computed by csrc/laws/joint/lyapunov.c.
"""

from __future__ import annotations

from .joint_space import JointSpaceController


class LyapunovController(JointSpaceController):
    """Control of joint positions that needs the robot's weight only.

    Arguments and attributes as of `JointSpaceController`, but for the units of the gains: kp in
    [N·m/rad], kd in [N·m·s/rad]; for prismatic joints [N/m], [N·s/m].
    """

    law = "lyapunov"
