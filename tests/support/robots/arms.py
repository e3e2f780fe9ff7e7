"""Closed-form dynamics for tests of controllers without a simulator."""

from __future__ import annotations

import numpy as np


class TwoLinkArm:
    """Two links of 1 m with point masses of 1 kg and straight antagonists; tasks x, z."""

    coordinate_names = ("shoulder", "elbow")
    muscle_names = ("a", "b", "c", "d")
    motor_names = ()
    f_min = np.full(4, 5.0)
    f_max = np.full(4, 5000.0)
    damping = np.array([0.3, 0.2])
    q_min = np.full(2, -np.inf)
    q_max = np.full(2, np.inf)
    task_names = ("tip.x", "tip.z")
    task_angles = np.zeros(2, dtype=bool)

    def mass_matrix(self, q):
        c = np.cos(q[1])
        return np.array([[3.0 + 2.0 * c, 1.0 + c], [1.0 + c, 1.0]])

    def coriolis(self, q, qd):
        s = np.sin(q[1])
        return s * np.array([-(2 * qd[0] + qd[1]) * qd[1], qd[0] ** 2])

    def gravity(self, q):
        g = 9.81
        outer = g * np.cos(q[0] + q[1])
        return np.array([2 * g * np.cos(q[0]) + outer, outer])

    def muscle_jacobian(self, q):
        return np.array([[-0.2, 0.0], [0.2, 0.0], [-0.1, -0.1], [0.1, 0.1]])

    def actuator_jacobian(self, q):
        return self.muscle_jacobian(q)

    def task_position(self, q):
        a, b = q[0], q[0] + q[1]
        return np.array([np.cos(a) + np.cos(b), np.sin(a) + np.sin(b)])

    def task_jacobian(self, q):
        a, b = q[0], q[0] + q[1]
        return np.array([[-np.sin(a) - np.sin(b), -np.sin(b)], [np.cos(a) + np.cos(b), np.cos(b)]])

    def task_bias(self, q, qd):
        a, b, ad, bd = q[0], q[0] + q[1], qd[0], qd[0] + qd[1]
        return -np.array(
            [np.cos(a) * ad**2 + np.cos(b) * bd**2, np.sin(a) * ad**2 + np.sin(b) * bd**2]
        )


class PointMass:
    """Mass of 2 kg with six cables along three axes; tasks x and y, without z."""

    coordinate_names = ("x", "y", "z")
    muscle_names = ("-x", "+x", "-y", "+y", "-z", "+z")
    motor_names = ()
    f_min = np.full(6, 1.0)
    f_max = np.full(6, 1000.0)
    damping = np.zeros(3)
    q_min = np.full(3, -np.inf)
    q_max = np.full(3, np.inf)
    task_names = ("mass.x", "mass.y")
    task_angles = np.zeros(2, dtype=bool)
    mass = 2.0

    def mass_matrix(self, q):
        return self.mass * np.eye(3)

    def coriolis(self, q, qd):
        return np.zeros(3)

    def gravity(self, q):
        return np.array([0.0, 0.0, 9.81 * self.mass])

    def muscle_jacobian(self, q):
        return np.kron(np.eye(3), np.array([[1.0], [-1.0]]))

    def actuator_jacobian(self, q):
        return self.muscle_jacobian(q)

    def task_position(self, q):
        return q[:2].copy()

    def task_jacobian(self, q):
        return np.eye(2, 3)

    def task_bias(self, q, qd):
        return np.zeros(2)
