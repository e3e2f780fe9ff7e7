"""Distances of moving segments of a robot from a fixed segment, with exact derivatives."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import Robot, Vector3
from addin_sdfusion.robot.model.robot import WORLD, TaskFrame, TaskSet
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.muscles.paths import MusclePaths

_TINY = 1e-12  # squared distances and determinants below this value are degenerate


class Segment(NamedTuple):
    """Segment between two points of links; a point if both are equal.

    Attributes:
        name: Name for messages.
        start, end: Link, or `WORLD`, and position in its frame, in [m].
        axes: Axes of the world frame in which distances are measured.
    """

    name: str
    start: tuple[str, Vector3]
    end: tuple[str, Vector3]
    axes: str = "xyz"


class SegmentDistances:
    """Distances of segments from the axis of an obstacle, as functions of states.

    Args:
        robot: The robot.
        segments: Segments, k of them.
        axis: End points of the axis, equal for a sphere, shape (2, 3), in [m].
        nx: Number of states; the first ones are q.

    Attributes:
        n: Number of coordinates.
    """

    def __init__(self, robot: Robot, segments: list[Segment], axis: FloatArray, nx: int) -> None:
        points = list(dict.fromkeys(end for one in segments for end in (one.start, one.end)))
        moving = [each for each in points if each[0] != WORLD]
        frames = tuple(TaskFrame(f"point_{k}", *each) for k, each in enumerate(moving))
        extended = replace(robot, task_sets=(TaskSet("obstacles", frames),), task_set="obstacles")
        self._paths = MusclePaths(extended if frames else robot)
        self.n, self._nx = len(robot.coordinates), nx
        self._moving = np.array([each in moving for each in points])
        self._fixed = np.array([position for _, position in points], dtype=float)
        self._starts = np.array([points.index(each.start) for each in segments])
        self._ends = np.array([points.index(each.end) for each in segments])
        self._axes = np.array([[axis in each.axes for axis in "xyz"] for each in segments])
        self._axis = axis

    def __call__(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the distances, shape (r, k), and their derivatives, shape (r, k, nx)."""
        gap, slope = self.nearest(x[:, : self.n])
        values = np.sqrt((gap**2).sum(axis=2))
        direction = gap / np.maximum(values, 1e-9)[:, :, None]
        slopes = np.zeros((*values.shape, self._nx))
        slopes[:, :, : self.n] = np.einsum("rki,rkij->rkj", direction, slope)
        return values, slopes

    def nearest(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the nearest points of the segments minus those of the axis, and derivatives.

        Args:
            q: Joint positions, shape (r, n).

        Returns:
            The differences, shape (r, k, 3), and the derivatives of the segments' points by q,
            shape (r, k, 3, n).
        """
        points, J = (
            np.tile(self._fixed, (len(q), 1, 1)),
            np.zeros((len(q), *self._fixed.shape, self.n)),
        )
        if self._moving.any():
            paths = self._paths
            points[:, self._moving] = [paths.task_position(row).reshape(-1, 3) for row in q]
            J[:, self._moving] = [paths.task_jacobian(row).reshape(-1, 3, self.n) for row in q]
        shape, axes = (len(q), len(self._starts), 1), np.tile(self._axes, (len(q), 1))
        a, b = (points[:, ends].reshape(-1, 3) * axes for ends in (self._starts, self._ends))
        c, d = (end * axes for end in self._axis)
        s, t = nearest_parameters(a, b, c, d)
        gap, s = a + s * (b - a) - c - t * (d - c), s.reshape(*shape, 1)
        slope = (1.0 - s) * J[:, self._starts] + s * J[:, self._ends]
        return gap.reshape(*shape[:2], 3), slope


def nearest_parameters(
    a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return s and t from 0 to 1 of the nearest points a + s (b - a) and c + t (d - c).

    Args:
        a: Start points of the first segments, shape (k, 3).
        b: End points of the first segments.
        c: Start points of the second segments.
        d: End points of the second segments.

    Returns:
        Each of shape (k, 1).
    """
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = (_dot(*pair) for pair in ((u, u), (v, v), (u, v)))
    uw, vw = _dot(u, w), _dot(v, w)
    determinant = uu * vv - uv**2
    s = np.clip(_ratio(uv * vw - vv * uw, determinant, uu * vv), 0.0, 1.0)
    t = np.clip(_ratio(uv * s + vw, vv, 1.0), 0.0, 1.0)
    return np.clip(_ratio(uv * t - uw, uu, 1.0), 0.0, 1.0), t


def _ratio(numerator: FloatArray, divisor: FloatArray, size: FloatArray | float) -> FloatArray:
    """Return a ratio, or 0 if the divisor is tiny relative to a size."""
    has = divisor > _TINY * np.maximum(size, _TINY)
    return np.where(has, numerator / np.where(has, divisor, 1.0), 0.0)


def _dot(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.asarray((u * v).sum(axis=1, keepdims=True))
