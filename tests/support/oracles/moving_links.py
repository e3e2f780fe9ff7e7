"""Mass matrix, gravity and straight paths of a robot in NumPy, from its description.

Couplings and locks are ignored: q contains every coordinate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Muscle, Pose, Robot
from addin_sdfusion.robot.model.function import derivatives
from addin_sdfusion.robot.model.rotations import rotation

Matrix = NDArray[np.float64]


class MovingLinks:
    """Robot at given values of all coordinates.

    Attributes:
        names: Names of the coordinates, in the order of rows and columns.
        poses: Pose of each link in the world, shape (4, 4).
        jacobians: Jacobian of each link: angular velocity, and velocity at the origin of the world.
    """

    def __init__(self, robot: Robot, q: Mapping[str, float]) -> None:
        self.robot, self.q = robot, dict(q)
        self.names = [c.name for joint in robot.joints for c in joint.coordinates]
        index = {name: k for k, name in enumerate(self.names)}
        self.poses = {"world": np.eye(4)}
        self.jacobians = {"world": np.zeros((6, len(self.names)))}
        for joint in robot.joints:
            T = self.poses[joint.parent] @ _matrix(joint.T_parent_joint)
            J = self.jacobians[joint.parent].copy()
            for motion in joint.motions:
                axis = np.array(motion.axis) / np.linalg.norm(motion.axis)
                name = joint.coordinates[motion.coordinate].name if joint.coordinates else ""
                way, slope, _ = derivatives(motion.function, self.q.get(name, 0.0))
                turned, step = T[:3, :3] @ axis, np.eye(4)
                if motion.kind == "rotation":
                    step[:3, :3] = _turn(axis, way)
                    column = np.concatenate([turned, np.cross(T[:3, 3], turned)])
                else:
                    step[:3, 3] = way * axis
                    column = np.concatenate([np.zeros(3), turned])
                if name:
                    J[:, index[name]] += slope * column
                T = T @ step
            self.poses[joint.child] = T @ np.linalg.inv(_matrix(joint.T_child_joint))
            self.jacobians[joint.child] = J

    def mass_and_gravity(self) -> tuple[Matrix, Matrix]:
        """Return M(q) with armature, and gravity g(q), where M q'' + g = tau at rest."""
        n = len(self.names)
        M, g = np.zeros((n, n)), np.zeros(n)
        for link in self.robot.links:
            T, J = self.poses[link.name], self.jacobians[link.name]
            com = T[:3, :3] @ np.array(link.inertia.com) + T[:3, 3]
            Jv = J[3:] - _cross(com) @ J[:3]
            inertia = T[:3, :3] @ np.array(link.inertia.matrix) @ T[:3, :3].T
            M += link.inertia.mass * Jv.T @ Jv + J[:3].T @ inertia @ J[:3]
            g -= link.inertia.mass * Jv.T @ np.array(self.robot.gravity)
        armature = [c.armature for joint in self.robot.joints for c in joint.coordinates]
        return M + np.diag(armature), g

    def straight_length(self, muscle: Muscle) -> float:
        """Return the length through the active points, without wraps; branches are divided."""
        length = 0.0
        divisors = {branch.point: branch.divisor for branch in muscle.branches}
        divisor, last = 1.0, None
        for k, point in enumerate(muscle.via_points):
            if k in divisors:
                divisor, last = divisors[k], None
            when = point.when
            if when is not None and not when.low <= self.q[when.coordinate] <= when.high:
                continue
            place = np.array(point.position)
            for move in point.moves:
                at = min(max(self.q[move.coordinate], move.low), move.high)
                place = place + derivatives(move.function, at)[0] * np.array(move.axis)
            here = (self.poses[point.link] @ np.array([*place, 1.0]))[:3]
            if last is not None:
                length += float(np.linalg.norm(here - last)) / divisor
            last = here
        return length + sum(term.factor * self.q[term.coordinate] for term in muscle.terms)


def _matrix(pose: Pose) -> Matrix:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation(pose.rpy), pose.position
    return T


def _cross(v: Matrix) -> Matrix:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def _turn(axis: Matrix, angle: float) -> Matrix:
    K = _cross(axis)
    turned: Matrix = np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K
    return turned
