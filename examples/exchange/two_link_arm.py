"""Plant of examples/planar_2r as an FMU of another tool, PythonFMU.

pythonfmu build -f two_link_arm.py
"""

from math import cos, hypot, sin

from pythonfmu import Fmi2Causality, Fmi2Slave, Real

MASS, GRAVITY = 0.1, 9.81
"""Mass of each link of 1 m, at its middle, in [kg]; gravity, in [m/s²]."""
CABLES = {"cable_1": (0.5, 0), "cable_2": (1.5, 1), "cable_3": (-0.5, 0), "cable_4": (-1.5, 1)}
"""Attachment of each cable to the ground, in [m], and the index of the link that it pulls."""


def cable_torques(ground, link, angles):
    """Return the torques of a cable force of 1 N at the absolute angles of the links, in [N m]."""
    side = 0.1 if ground > 0 else -0.1
    s, c = sin(angles[link]), cos(angles[link])
    x, z = side * c + 0.8 * s, 0.8 * c - side * s
    if link == 1:
        x, z = x + sin(angles[0]), z + cos(angles[0])
    length = hypot(ground - x, z)
    pull = ((ground - x) / length, -z / length)
    torques = [0.0, 0.0]
    torques[link] = pull[0] * (0.8 * c - side * s) - pull[1] * (side * c + 0.8 * s)
    if link == 1:
        torques[0] = pull[0] * cos(angles[0]) - pull[1] * sin(angles[0])
    return torques


class TwoLinkArm(Fmi2Slave):
    """Two-link arm; its variables have the names of the robot's ports."""

    def __init__(self, **kwargs):
        """Start at rest in the first pose of the reference."""
        super().__init__(**kwargs)
        self.inputs = {f"f.{cable}": 0.0 for cable in CABLES}
        self.outputs = {"q.joint_1": -0.5, "q.joint_2": 0.5, "qd.joint_1": 0.0, "qd.joint_2": 0.0}
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
        """Step Lagrange's equations in absolute angles by the semi-implicit Euler method."""
        q1, q2, v1, v2 = self.outputs.values()
        angles, rates = (q1, q1 + q2), (v1, v1 + v2)
        between = angles[0] - angles[1]
        t1 = 1.5 * MASS * GRAVITY * sin(angles[0]) - 0.5 * MASS * sin(between) * rates[1] ** 2
        t2 = 0.5 * MASS * GRAVITY * sin(angles[1]) + 0.5 * MASS * sin(between) * rates[0] ** 2
        for (ground, link), force in zip(CABLES.values(), self.inputs.values(), strict=True):
            torques = cable_torques(ground, link, angles)
            t1, t2 = t1 + torques[0] * force, t2 + torques[1] * force
        m11, m12, m22 = 1.25 * MASS, 0.5 * MASS * cos(between), 0.25 * MASS
        determinant = m11 * m22 - m12 * m12
        a1, a2 = (m22 * t1 - m12 * t2) / determinant, (m11 * t2 - m12 * t1) / determinant
        v1, v2 = v1 + step_size * a1, v2 + step_size * (a2 - a1)
        q1, q2 = q1 + step_size * v1, q2 + step_size * v2
        self.outputs.update(zip(self.outputs, (q1, q2, v1, v2), strict=True))
        return True
