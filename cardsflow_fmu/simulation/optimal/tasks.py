"""Functions of states with derivatives, and bounds of task coordinates."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.settings import MotionTable
from cardsflow_fmu.experiment.settings.predictive import override
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.arrays import IntArray
from controllers.optimal.problem import NodeConstraint
from sim_dart.dynamics.core import CoreDynamics

from .muscles import require_order


class TaskRows:
    """Some task coordinates y(q) with their derivatives by the states.

    Args:
        dynamics: The robot.
        rows: Indices of the task coordinates.
        nx: Number of states.
    """

    def __init__(self, dynamics: CoreDynamics, rows: IntArray, nx: int) -> None:
        self._dynamics, self._rows, self._nx = dynamics, rows, nx

    def __call__(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return y, shape (k, rows), and its derivatives, shape (k, rows, nx)."""
        dynamics, n = self._dynamics, self._dynamics.n
        y = np.array([dynamics.task_position(row[:n])[self._rows] for row in x])
        J = np.zeros((*y.shape, self._nx))
        for k, row in enumerate(x):
            J[k, :, :n] = dynamics.task_jacobian(row[:n])[self._rows]
        return y, J


class TaskRates(TaskRows):
    """Rates J(q) qd of some task coordinates with their derivatives by the states.

    The bias b(q, v) = J'(q, v) v is quadratic in v, and J is a derivative, so that the derivative
    of J qd by q_j is (b(q, qd + e_j) - b(q, qd - e_j)) / 4 exactly.
    """

    def __call__(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return yd, shape (k, rows), and its derivatives, shape (k, rows, nx)."""
        dynamics, n = self._dynamics, self._dynamics.n
        yd, J = np.empty((len(x), len(self._rows))), np.zeros((len(x), len(self._rows), self._nx))
        for k, row in enumerate(x):
            q, qd = row[:n], row[n : 2 * n]
            J[k, :, n : 2 * n] = dynamics.task_jacobian(q)[self._rows]
            yd[k] = J[k, :, n : 2 * n] @ qd
            for j, unit in enumerate(np.eye(n)):
                change = dynamics.task_bias(q, qd + unit) - dynamics.task_bias(q, qd - unit)
                J[k, :, j] = 0.25 * change[self._rows]
        return yd, J


class StateRows:
    """Some states with their derivatives by the states.

    Args:
        rows: Indices of the states.
        nx: Number of states.
    """

    def __init__(self, rows: IntArray, nx: int) -> None:
        self._rows, self._unit = rows, np.eye(nx)[rows]

    def __call__(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the states, shape (k, rows), and their derivatives, shape (k, rows, nx)."""
        return x[:, self._rows], np.tile(self._unit, (len(x), 1, 1))


def task_bounds(
    experiment: Experiment, motion: MotionTable, dynamics: CoreDynamics, nodes: IntArray, nx: int
) -> list[NodeConstraint]:
    """Return the constraint of bounds of task coordinates, if there are some.

    Raises:
        InputError: The start is beyond the bounds, or a maximum is below the minimum.
    """
    k, bounds = len(dynamics.task_names), motion.bounds
    low = override(np.full(k, -np.inf), bounds.y_min)
    high = override(np.full(k, np.inf), bounds.y_max)
    y = dynamics.task_position(experiment.start.q)
    for name, least, most, value in zip(dynamics.task_names, low, high, y, strict=True):
        require_order(experiment, f"y_max.{name}", least, most)
        if nodes[0] and not least <= value <= most:
            problem = f"{name} starts at {value:.6g}, beyond its bounds {least:.6g} to {most:.6g}"
            key = f"y_min.{name}" if value < least else f"y_max.{name}"
            raise InputError(problem, file=experiment.file, key=f"motion.bounds.{key}")
    rows = np.flatnonzero(np.isfinite(low) | np.isfinite(high))
    if not len(rows):
        return []
    names, evaluate = tuple(dynamics.task_names[row] for row in rows), TaskRows(dynamics, rows, nx)
    return [NodeConstraint("bounds.y", names, nodes, evaluate, low[rows], high[rows])]
