"""References in joint space: splines through given points, as CASPR defines them."""

from __future__ import annotations

import bisect
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BPoly, PPoly

from addin_sdfusion.robot.trajectory import Trajectory

FloatArray = NDArray[np.float64]


class JointReference(NamedTuple):
    """A point of a reference.

    Attributes:
        q: Positions, shape (n,), in [rad] or [m].
        qd: Velocities, shape (n,), in [rad/s] or [m/s].
        qdd: Accelerations, shape (n,), in [rad/s²] or [m/s²].
    """

    q: FloatArray
    qd: FloatArray
    qdd: FloatArray


class SplineReference:
    """A piecewise polynomial through the points of a trajectory.

    A linear spline matches their positions, a cubic one (Hermite) their velocities as well, a
    quintic one their accelerations too.

    Before the first point and after the last, it rests there.

    Args:
        trajectory: The points.

    Attributes:
        name: The trajectory's name.
        duration: Time of the last point, in [s].
    """

    def __init__(self, trajectory: Trajectory) -> None:
        points = trajectory.points
        self.name = trajectory.name
        self._times = [point.time for point in points]
        self.duration = self._times[-1]
        derivatives = [
            [row for row in (point.q, point.qd, point.qdd) if len(row)] for point in points
        ]
        bernstein = BPoly.from_derivatives(self._times, derivatives)
        power = PPoly.from_bernstein_basis(bernstein).c  # (degree + 1, segments, n), highest first
        self._coefficients = np.ascontiguousarray(power[::-1].transpose(1, 0, 2))
        self._orders = np.arange(self._coefficients.shape[1])
        rest = np.zeros(len(points[0].q))
        self._first = JointReference(np.array(points[0].q), rest, rest)
        self._last = JointReference(np.array(points[-1].q), rest, rest)

    def evaluate(self, t: float) -> JointReference:
        """The reference at a time.

        Args:
            t: Time, in [s].
        """
        if t < 0.0:
            return self._first
        if t > self.duration:
            return self._last
        segment = min(bisect.bisect_right(self._times, t), len(self._times) - 1) - 1
        rows = self._powers(t - self._times[segment]) @ self._coefficients[segment]
        return JointReference(rows[0], rows[1], rows[2])

    def _powers(self, s: float) -> FloatArray:
        """s^k and its two derivatives for every order k, shape (3, degree + 1)."""
        k = self._orders
        powers = s ** np.arange(k.size, dtype=np.float64)
        table = np.zeros((3, k.size))
        table[0] = powers
        table[1, 1:] = k[1:] * powers[:-1]
        table[2, 2:] = (k * (k - 1))[2:] * powers[:-2]
        return table
