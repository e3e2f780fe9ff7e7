"""Custom costs of optimal motions: import, checks, and derivatives by finite differences."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.custom_code import call_custom, load_class
from cardsflow_fmu.experiment.config.custom_law import CustomLaw
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.settings import MotionTable
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.optimal.custom import MotionCost, MotionState
from controllers.optimal.node_costs import NodeCost, function_cost
from sim_dart.dynamics.core import CoreDynamics

_STEP = 1e-5  # of finite differences
_GRADIENT_ERROR = 1e-4  # of a custom gradient, relative to the largest derivative
_OFFSET = 0.1  # of the state at which gradients are checked from the start


def custom_costs(
    experiment: Experiment, motion: MotionTable, dynamics: CoreDynamics, nx: int
) -> list[NodeCost]:
    """Return the costs of the class in `motion.cost.function`. This executes its file.

    Raises:
        InputError: The class cannot be used, or a gradient differs from finite differences.
    """
    assert motion.cost.function is not None
    law = CustomLaw.of(motion.cost.function)
    assert law is not None
    file, N = experiment.file.parent / law.file, motion.intervals
    try:
        kind = load_class(file, law.name, MotionCost)
    except InputError as error:
        error.key = error.key or "motion.cost.function"
        raise
    instance, costs = call_custom(file, kind), list[NodeCost]()
    for method in ("running", "final"):
        if getattr(kind, method) is getattr(MotionCost, method):
            continue
        nodes = np.arange(N + 1) if method == "running" else np.array([N])
        function = _Function(instance, method, file, dynamics, nodes / N, nx)
        function.check(np.concatenate([experiment.start.q, experiment.start.qd]))
        values = function.value, function.gradient
        costs.append(function_cost(nodes, method == "running", *values, 2 * dynamics.n))
    if not costs:
        problem = f"{law.name} defines neither running nor final; define one of them"
        raise InputError(problem, file=file)
    return costs


class _Function:
    """Method of a custom cost as a function of states.

    Args:
        cost: The custom cost.
        method: Name of the method.
        file: File of the class, for messages.
        dynamics: The robot.
        fractions: Times of the nodes as fractions of the duration, shape (k,).
        nx: Number of states.
    """

    def __init__(
        self,
        cost: MotionCost,
        method: str,
        file: Path,
        dynamics: CoreDynamics,
        fractions: FloatArray,
        nx: int,
    ) -> None:
        self._file, self._dynamics, self._fractions = file, dynamics, fractions
        self._name, self._nx = f"{type(cost).__name__}.{method}", nx
        self._call = getattr(cost, method)
        self._slope = getattr(cost, f"{method}_gradient", None)

    def value(self, x: FloatArray) -> FloatArray:
        """Return the values at states, shape (k,)."""
        return np.array([self._one(row, s) for row, s in zip(x, self._fractions, strict=True)])

    def gradient(self, x: FloatArray) -> FloatArray:
        """Return the gradients at states, shape (k, nx)."""
        gradients = np.zeros((len(x), self._nx))
        slope = self._differences if self._slope is None else self._given
        for k, (row, s) in enumerate(zip(x, self._fractions, strict=True)):
            gradients[k, : 2 * self._dynamics.n] = slope(row, s)
        return gradients

    def check(self, start: FloatArray) -> None:
        """Compare a custom gradient with finite differences near the start, shape (2 n,)."""
        n = self._dynamics.n
        at, s = start + _OFFSET * np.cos(np.arange(2 * n)), float(self._fractions[-1])
        expected = self._differences(at, s)
        if self._slope is None:
            return
        error = abs(self._given(at, s) - expected)
        if error.max() > _GRADIENT_ERROR * max(1e-6, abs(expected).max()):
            k = int(error.argmax())
            names = [f"{p}.{name}" for p in ("q", "qd") for name in self._dynamics.coordinate_names]
            problem = f"{self._name}_gradient returns {self._given(at, s)[k]:.6g} for {names[k]}"
            problem += f", but finite differences are {expected[k]:.6g}"
            raise InputError(f"{problem}; correct it or remove it", file=self._file)

    def _state(self, x: FloatArray, fraction: float) -> MotionState:
        dynamics, n = self._dynamics, self._dynamics.n
        q, qd = x[:n].copy(), x[n : 2 * n].copy()
        J = dynamics.task_jacobian(q)
        return MotionState(q, qd, dynamics.task_position(q), J @ qd, J, float(fraction))

    def _one(self, x: FloatArray, fraction: float) -> float:
        state = self._state(x, fraction)
        value = call_custom(self._file, lambda: float(self._call(state)))
        if not np.isfinite(value):
            raise InputError(f"{self._name} returned {value}; it must be finite", file=self._file)
        return value

    def _given(self, x: FloatArray, fraction: float) -> FloatArray:
        assert self._slope is not None
        state, n, slope = self._state(x, fraction), self._dynamics.n, self._slope
        parts = call_custom(
            self._file, lambda: [np.asarray(k, dtype=np.float64) for k in slope(state)]
        )
        if [k.shape for k in parts] != [(n,), (n,)] or not np.isfinite(parts).all():
            problem = f"{self._name}_gradient must return two finite arrays of shape ({n},)"
            raise InputError(f"{problem}: the derivatives by q and qd", file=self._file)
        return np.concatenate(parts)

    def _differences(self, x: FloatArray, fraction: float) -> FloatArray:
        slope = np.empty(2 * self._dynamics.n)
        for k in range(len(slope)):
            step = np.zeros(len(x))
            step[k] = _STEP
            ahead, behind = self._one(x + step, fraction), self._one(x - step, fraction)
            slope[k] = (ahead - behind) / (2.0 * _STEP)
        return slope
