"""Numbers of a robot's blob as functions of free parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import CardsflowError, Robot
from sim_dart.core.arrays import FloatArray, IntArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import blob_fields

_LINEAR = 1e-9  # relative deviation of numbers from a linear function of the parameters
_STEP = 1e-6  # of a difference, relative to the range of a parameter


class RobotFamily(NamedTuple):
    """Robots that differ in the values of free parameters.

    Attributes:
        robot_at: Function of the values, shape (np,), that returns the robot.
        low, high: Bounds of the parameters, shape (np,), finite.
        nominal: Values of the original robot, shape (np,), within the bounds.
    """

    robot_at: Callable[[FloatArray], Robot]
    low: FloatArray
    high: FloatArray
    nominal: FloatArray


class RobotNumbers:
    """Blob of a robot, and the derivatives of its numbers, as functions of free parameters.

    Most parameters, such as positions, masses and stiffnesses, change the numbers linearly, so that
    no robot is compiled again. For others, such as the mass of a link that is merged with another
    one, derivatives are differences of compiled robots.

    Args:
        family: The robots.
        prepare: Function of a robot that returns the robot to be compiled.

    Attributes:
        is_linear: Whether all numbers are linear functions of the parameters.

    Raises:
        CardsflowError: A parameter changes the number of parts of the robot.
    """

    def __init__(self, family: RobotFamily, prepare: Callable[[Robot], Robot]) -> None:
        self._family, self._prepare = family, prepare
        base = compile_blob(prepare(family.robot_at(family.nominal)))
        fields = [(name, *field) for name, field in blob_fields(base).items() if field[2] == "real"]
        self._fields = [name for name, _, size, _ in fields for _ in range(size)]
        self._places: IntArray = np.concatenate(
            [at // 8 + np.arange(size) for _, at, size, _ in fields]
        )
        self._blob = np.frombuffer(base, "<f8").copy()
        self._nominal = self._blob[self._places]
        others = np.ones(len(self._blob), dtype=bool)
        others[self._places] = False
        self._others = np.flatnonzero(others)
        low, nominal, high = family.low, family.nominal, family.high
        ends = np.where(high - nominal > nominal - low, high, low)
        self._slopes = self._differences(nominal, ends - nominal, 0.0)
        inside = low + (high - low) * np.linspace(0.3, 0.8, len(low))
        compiled, linear = self._compile(inside), self._at(inside)
        size = np.where(np.isfinite(compiled), abs(compiled) + abs(self._nominal), 1.0)
        with np.errstate(invalid="ignore"):
            off = np.where(compiled == linear, 0.0, abs(compiled - linear))
        self.is_linear = bool((off <= _LINEAR * size).all())

    def blob(self, p: FloatArray) -> bytes:
        """Return the blob for values p, shape (np,)."""
        blob = self._blob.copy()
        blob[self._places] = self._at(p) if self.is_linear else self._compile(p)
        return blob.tobytes()

    def slopes(self, p: FloatArray) -> FloatArray:
        """Return the derivatives of the numbers at values p, shape (np, numbers)."""
        if self.is_linear:
            return self._slopes
        return self._differences(p, _STEP * (self._family.high - self._family.low), 1.0)

    def changed_fields(self, p: FloatArray) -> list[list[str]]:
        """Return the names of the fields that each parameter changes."""
        rows = [np.flatnonzero(row).tolist() for row in self.slopes(p)]
        return [list(dict.fromkeys(self._fields[k] for k in row)) for row in rows]

    def _at(self, p: FloatArray) -> FloatArray:
        numbers: FloatArray = self._nominal + (p - self._family.nominal) @ self._slopes
        return numbers

    def _compile(self, p: FloatArray) -> FloatArray:
        blob = compile_blob(self._prepare(self._family.robot_at(p)))
        values = np.frombuffer(blob, "<f8")
        same = len(values) == len(self._blob) and (
            values[self._others].tobytes() == self._blob[self._others].tobytes()
        )
        if not same:
            raise CardsflowError("a free parameter must not change the number of parts of a robot")
        numbers: FloatArray = values[self._places]
        return numbers

    def _differences(self, p: FloatArray, steps: FloatArray, back: float) -> FloatArray:
        """Return slopes by differences from p - back * step to p + step of each parameter."""
        slopes = np.zeros((len(p), len(self._places)))
        for k, step in enumerate(steps.tolist()):
            along = np.zeros(len(p))
            along[k] = step
            ahead, behind = self._compile(p + along), self._compile(p - back * along)
            is_same = ahead == behind  # also limits that are infinite
            moved = np.where(is_same, 0.0, ahead) - np.where(is_same, 0.0, behind)
            slopes[k] = moved / ((1.0 + back) * step)
        return slopes
