"""Muscle forces that were found for a torque, and how far they are off."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from controllers.arrays import BoolArray, FloatArray

Status = Literal["solved", "soft", "not converged"]
STATUSES: tuple[Status, ...] = ("solved", "soft", "not converged")
"""By their numbers in C."""

_AT_BOUND = 1e-9  # a force this close to a bound is at it, relative to 1 N or the bound


@dataclass(frozen=True)
class ForceSolution:
    """Muscle forces for a desired torque, with measures of their error.

    Attributes:
        forces: f, shape (m,), in [N]; always within the bounds.
        status: `solved`; `soft` if it is proven that no force within the bounds makes the
            torque; `not converged` if none was found, and none may or may not be, or where
            these are of least squares, as those of the norm were not found.
        slack: Torque that is missing, tau + L'f, shape (n,), in [N·m] or [N].
        f_min, f_max: The bounds, shape (m,), in [N].
        coordinate_names: n names.
        muscle_names: m names; of the coordinates that have motors behind those of the muscles.
    """

    forces: FloatArray
    status: Status
    slack: FloatArray
    f_min: FloatArray
    f_max: FloatArray
    coordinate_names: tuple[str, ...]
    muscle_names: tuple[str, ...]

    @property
    def equality_residual(self) -> float:
        """Largest torque error, max |tau + L'f|, in [N·m] or [N]."""
        return float(np.max(np.abs(self.slack), initial=0.0))

    @property
    def bound_violation(self) -> float:
        """Largest distance of a force from its bounds, in [N]; 0 when all are within."""
        outside = np.maximum(self.f_min - self.forces, self.forces - self.f_max)
        return float(np.max(outside, initial=0.0))

    @property
    def at_min(self) -> tuple[str, ...]:
        """Names of the muscles and motors at their lower bound."""
        return self._named(self._near_min)

    @property
    def at_max(self) -> tuple[str, ...]:
        """Names of the muscles and motors at their upper bound."""
        return self._named(self._near_max)

    @property
    def count_at_bounds(self) -> int:
        """Number of muscles and motors at a bound."""
        return int(np.count_nonzero(self._near_min | self._near_max))

    @property
    def _near_min(self) -> BoolArray:
        return self.forces - self.f_min <= _AT_BOUND * np.maximum(1.0, self.f_min)

    @property
    def _near_max(self) -> BoolArray:
        finite = np.where(np.isfinite(self.f_max), self.f_max, np.finfo(float).max)
        return finite - self.forces <= _AT_BOUND * np.maximum(1.0, finite)

    def _named(self, chosen: BoolArray) -> tuple[str, ...]:
        return tuple(name for name, at in zip(self.muscle_names, chosen, strict=True) if at)

    def describe(self) -> str:
        """One line: the slack by coordinate, and the muscles at their bounds."""
        slack = ", ".join(
            f"{name} {value:.3g}"
            for name, value in zip(self.coordinate_names, self.slack, strict=True)
        )
        bounds = [
            f"at {bound}: {', '.join(names)}"
            for bound, names in (("f_min", self.at_min), ("f_max", self.at_max))
            if names
        ]
        return "; ".join([f"{self.status}: slack {slack}", *bounds])
