"""Fibres and tendons of Hill-type muscles at many points at once, with exact derivatives."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import Muscle, Robot
from addin_sdfusion.robot.model.muscle_laws import law_parameters
from sim_dart.core.arrays import BoolArray, FloatArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core

FIBRE_LAWS = ("hill_degroote2016", "hill_thelen2003", "hill_millard2012")
"""Muscle laws that `core_fibres` supports."""
FIBRE_POINT, FIBRE_VALUES = 5, 14
"""Numbers of a point and of its value; see `core_fibres` in core.h."""


class HillMuscles:
    """Hill-type muscles of a robot, independent of its motion.

    Args:
        robot: A valid robot whose m muscles have laws of `FIBRE_LAWS`.

    Attributes:
        force: Maximum isometric forces F0, shape (m,), in [N].
        optimal: Optimal fibre lengths, shape (m,), in [m].
        slack: Tendon slack lengths, shape (m,), in [m].
        height: Thickness of the muscles, (fibre length) sin(pennation), shape (m,), in [m].
        speed: Maximum contraction velocities, shape (m,), in [m/s].
        low: Minimum activations, shape (m,).
        elastic: Whether tendons are elastic, shape (m,).
        shortest: Shortest fibre lengths, shape (m,), in [m].
    """

    def __init__(self, robot: Robot) -> None:
        parameters = [law_parameters(muscle.model) for muscle in robot.muscles]

        def numbers(name: str) -> FloatArray:
            return np.array([each.get(name, 0.0) for each in parameters])

        self.force, self.optimal = numbers("max_isometric_force"), numbers("optimal_fibre_length")
        self.slack = numbers("tendon_slack_length")
        self.height = self.optimal * np.sin(numbers("pennation_at_optimal"))
        self.speed = self.optimal * numbers("max_contraction_velocity")
        self.low = numbers("minimum_activation")
        self.elastic: BoolArray = numbers("elastic_tendon") != 0.0
        self._core = Core(compile_blob(robot))
        self.shortest = self.fibres(np.zeros((1, len(parameters), FIBRE_POINT)))[0, :, 13]

    def fibres(self, points: FloatArray) -> FloatArray:
        """Return the values of `core_fibres` at points, shape (K, m, 5) to (K, m, 14)."""
        return self._call(self._core.fibres, points, FIBRE_VALUES)

    def tendons(self, points: FloatArray) -> FloatArray:
        """Return the values of `core_tendons` at points, shape (K, m, 2) to (K, m, 2)."""
        return self._call(self._core.tendons, points, 2)

    def rigid(self, lengths: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return fibre lengths and velocities with rigid tendons.

        Args:
            lengths: Path lengths, shape (K, m), in [m].
            rates: Path velocities, shape (K, m), in [m/s].
        """
        along = np.maximum(lengths - self.slack, 1e-6)
        fibres = np.hypot(along, self.height)
        return fibres, rates * along / fibres

    def _call(self, function: object, points: FloatArray, size: int) -> FloatArray:
        points, values = np.ascontiguousarray(points), np.zeros((*points.shape[:2], size))
        function(self._core.handle, len(points), points.ctypes.data, values.ctypes.data)  # type: ignore[operator]
        return values


def has_fibres(muscle: Muscle) -> bool:
    """Return whether `core_fibres` supports the law of a muscle."""
    return muscle.model.kind in FIBRE_LAWS
