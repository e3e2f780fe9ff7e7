"""What the dynamics of a robot have whichever engine computes them: names, bounds, paths, tasks."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.muscles.paths import MusclePaths


class RobotTerms:
    """Names, bounds, muscle paths and tasks of a robot, for controllers.

    Every array returned is the caller's own.

    Args:
        robot: The robot; its active cable set and operational space count.

    Raises:
        RobotError: The robot is not valid.

    Attributes:
        robot: The robot.
        n: Number of coordinates.
        m: Number of muscles.
        f_min, f_max: Force bounds, shape (m,), in [N].
        damping: Viscous joint damping, shape (n,), in [N·m·s/rad] or [N·s/m].
        q_min, q_max: Joint limits, shape (n,), in [rad] or [m]; infinite where there is none.
        actuation: A, which gives motors of the joints their coordinates, shape (n, actuated).
        task_names: k names, in the order of y, such as `hand.x`.
        task_angles: Which task coordinates are angles, shape (k,).
    """

    def __init__(self, robot: Robot) -> None:
        self._paths = MusclePaths(robot)
        self.robot = robot
        self.coordinate_names = tuple(c.name for c in robot.coordinates)
        self.muscle_names = tuple(muscle.name for muscle in robot.muscles)
        self.n = len(self.coordinate_names)
        self.m = len(self.muscle_names)
        self.f_min = np.array([muscle.f_min for muscle in robot.muscles])
        self.f_max = np.array([muscle.f_max for muscle in robot.muscles])
        self.damping = np.array([c.damping for c in robot.coordinates])
        self.actuation = np.eye(self.n)[:, [c.actuated for c in robot.coordinates]]
        self.q_min = np.array([c.lower for c in robot.coordinates])
        self.q_max = np.array([c.upper for c in robot.coordinates])
        frames = [(frame, axis) for frame in robot.task_frames for axis in frame.axes]
        self.task_names = tuple(f"{frame.name}.{axis}" for frame, axis in frames)
        self.task_angles = np.array([frame.is_orientation for frame, _ in frames], dtype=bool)

    def muscle_lengths(self, q: ArrayLike) -> FloatArray:
        """l(q), shape (m,), in [m].

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        return self._paths.evaluate(q).lengths.copy()

    def muscle_jacobian(self, q: ArrayLike) -> FloatArray:
        """L(q) = dl/dq, shape (m, n), in [m/rad] or [m/m].

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        return self._paths.evaluate(q).jacobian.copy()

    def task_position(self, q: ArrayLike) -> FloatArray:
        """Task coordinates y(q), shape (k,), in [m] or [rad]: the active frames' axes, in order.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        return self._paths.task_position(q)

    def task_jacobian(self, q: ArrayLike) -> FloatArray:
        """J(q) = dy/dq, shape (k, n): y' = J q' for positions and angles alike.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        return self._paths.task_jacobian(q)

    def point_jacobian(self, q: ArrayLike) -> FloatArray:
        """Linear Jacobians of the task frames that are points, shape (3 p, n), world axes.

        Its transpose makes generalised forces of forces on these points, whichever of their axes
        count in y.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        return self._paths.point_jacobian(q)
