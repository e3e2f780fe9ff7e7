"""Pose that best fits measured muscle lengths."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.muscles.paths import MusclePaths

_ITERATIONS = 20
_MAX_STEP = 0.2
_SMALL = 1e-7
_DAMPING = 1e-8
_MAX_ERROR = 10.0
"""Limit of length errors, in [m], since a defective sensor can report any value."""


class FittedPose:
    """Minimisation of |l - b - l(q)|^2 over all taut muscles by the Gauss-Newton method.

    The fit is used for display and for limits that stop a run. It does not use dynamics. A pose
    estimator with the same lengths is several times as accurate.

    Args:
        q: Start pose, shape (n,), in [rad] or [m].
        offsets: Length offsets b, shape (m,), in [m].
        slack: Tension below which a muscle is ignored, a number or shape (m,), in [N].

    Attributes:
        q: The pose, shape (n,), changed in place.
    """

    def __init__(self, robot: Robot, q: FloatArray, offsets: FloatArray, slack: ArrayLike) -> None:
        self.q = q.copy()
        self._paths, self._offsets, self._slack = MusclePaths(robot), offsets, np.asarray(slack)

    def follow(self, lengths: FloatArray, tensions: FloatArray) -> None:
        """Update the pose with new measurements.

        Args:
            lengths: Measured lengths, shape (m,), in [m].
            tensions: Measured tensions, shape (m,), in [N].
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
