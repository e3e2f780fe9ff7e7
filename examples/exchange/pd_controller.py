"""PD controller of the two-link arm as an FMU of another tool, PythonFMU.

pythonfmu build -f pd_controller.py two_link_arm.py
"""

from pythonfmu import Fmi2Causality, Fmi2Slave, Real
from two_link_arm import CABLES, cable_torques

JOINTS = ("joint_1", "joint_2")
KP, KD = 100.0, 5.0
"""Gains, in [N m/rad] and [N m s/rad]."""
MEAN, MIN_FORCE, MAX_FORCE = 30.0, 10.0, 100.0
"""Cable forces, in [N]: the closest ones to the mean that produce the torques, then clipped."""


class PdController(Fmi2Slave):
    """PD controller without a model of inertia and gravity; its tracking error is not zero."""

    def __init__(self, **kwargs):
        """Declare variables with the names of the robot's ports, so that no mapping is needed."""
        super().__init__(**kwargs)
        groups = ("q", "qd", "q_d", "qd_d")
        self.inputs = {f"{group}.{joint}": 0.0 for group in groups for joint in JOINTS}
        self.outputs = {f"f.{cable}": MEAN for cable in CABLES}
        for name in self.inputs:
            self.declare(self.inputs, name, Fmi2Causality.input)
        for name in self.outputs:
            self.declare(self.outputs, name, Fmi2Causality.output)

    def declare(self, values, name, causality):
        """Register a variable whose value is in a dictionary."""
        self.register_variable(
            Real(
                name,
                causality=causality,
                getter=lambda: values[name],
                setter=lambda value: values.update({name: value}),
            )
        )

    def do_step(self, current_time, step_size):
        """Compute the cable forces from positions, velocities and their references."""
        s = self.inputs
        t1, t2 = (
            KP * (s[f"q_d.{j}"] - s[f"q.{j}"]) + KD * (s[f"qd_d.{j}"] - s[f"qd.{j}"])
            for j in JOINTS
        )
        angles = (s["q.joint_1"], s["q.joint_1"] + s["q.joint_2"])
        links = [cable_torques(ground, link, angles) for ground, link in CABLES.values()]
        arms = [(first + second, second) for first, second in links]  # about the joints
        t1, t2 = t1 - MEAN * sum(a for a, _ in arms), t2 - MEAN * sum(b for _, b in arms)
        s11, s12, s22 = (sum(arm[i] * arm[j] for arm in arms) for i, j in ((0, 0), (0, 1), (1, 1)))
        determinant = s11 * s22 - s12 * s12
        x1, x2 = (s22 * t1 - s12 * t2) / determinant, (s11 * t2 - s12 * t1) / determinant
        for cable, (a, b) in zip(CABLES, arms, strict=True):
            self.outputs[f"f.{cable}"] = min(max(MEAN + a * x1 + b * x2, MIN_FORCE), MAX_FORCE)
        return True
