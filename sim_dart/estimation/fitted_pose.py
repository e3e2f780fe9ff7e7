"""The pose that fits the lengths of muscles best, from one reading to the next."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.muscles.paths import MusclePaths

_ITERATIONS = 20
_MAX_STEP = 0.2
_SMALL = 1e-7
_DAMPING = 1e-8
_MAX_ERROR = 10.0
"""In [m]: what a broken sensor says may be any number, and steps are clipped anyway."""


class FittedPose:
    """Gauss and Newton's method for min |l - b - l(q)|^2 over muscles that are taut.

    It has no dynamics: what an estimator makes of the same lengths is several times better. It
    shows where a robot is, and serves limits that end a run.

    Args:
        robot: The robot.
        q: Where to begin, shape (n,), in [rad] or [m].
        offsets: b, shape (m,), in [m].
        slack: Muscles with less tension are left out, in [N].

    Attributes:
        q: The pose, shape (n,); changed in place.
    """

    def __init__(self, robot: Robot, q: FloatArray, offsets: FloatArray, slack: float) -> None:
        self.q = q.copy()
        self._paths, self._offsets, self._slack = MusclePaths(robot), offsets, slack

    def follow(self, lengths: FloatArray, tensions: FloatArray) -> None:
        """Take a reading.

        Args:
            lengths: Shape (m,), in [m].
            tensions: Shape (m,), in [N].
        """
        taut = tensions >= self._slack
        for _ in range(_ITERATIONS):
            path = self._paths.evaluate(self.q)
            away = np.clip(lengths - self._offsets - path.lengths, -_MAX_ERROR, _MAX_ERROR)
            L, e = path.jacobian[taut], away[taut]
            H = L.T @ L + _DAMPING * np.eye(len(self.q))
            step = np.clip(np.linalg.solve(H, L.T @ e), -_MAX_STEP, _MAX_STEP)
            self.q += step
            if np.abs(step).max(initial=0.0) < _SMALL:
                return
