"""Muscle forces for a desired torque, and measures of their error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from controllers.arrays import BoolArray, FloatArray

Status = Literal["solved", "soft", "not converged"]
STATUSES: tuple[Status, ...] = ("solved", "soft", "not converged")
"""Names of the status codes of the C core, in order."""

_AT_LIMIT = 1e-9  # maximum distance of a force that is at its limit, relative to 1 N or the limit


@dataclass(frozen=True)
class ForceSolution:
    """Muscle forces for a desired torque, with measures of their error.

    Attributes:
        forces: f, shape (m,), in [N]; always within the force limits.
        status: `solved`; `soft` if the torque is provably infeasible; `not converged` if the
            solver found neither a solution nor a proof, or if it found least-squares forces
            instead of forces for the specified norm.
        slack: Missing torque tau + L'f, shape (n,), in [N·m] or [N].
        f_min, f_max: Force limits, shape (m,), in [N].
        coordinate_names: n names.
        muscle_names: m names. The coordinates with motors follow the muscles.
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
        """Largest violation of a force limit, in [N]; 0 if all forces are within the limits."""
        outside = np.maximum(self.f_min - self.forces, self.forces - self.f_max)
        return float(np.max(outside, initial=0.0))

    @property
    def at_min(self) -> tuple[str, ...]:
        """Names of the muscles and motors at their lower limit."""
        return self._select_names(self._near_min)

    @property
    def at_max(self) -> tuple[str, ...]:
        """Names of the muscles and motors at their upper limit."""
        return self._select_names(self._near_max)

    @property
    def _near_min(self) -> BoolArray:
        return self.forces - self.f_min <= _AT_LIMIT * np.maximum(1.0, self.f_min)

    @property
    def _near_max(self) -> BoolArray:
        finite = np.where(np.isfinite(self.f_max), self.f_max, np.finfo(float).max)
        return finite - self.forces <= _AT_LIMIT * np.maximum(1.0, finite)

    def _select_names(self, chosen: BoolArray) -> tuple[str, ...]:
        return tuple(name for name, at in zip(self.muscle_names, chosen, strict=True) if at)

    def describe(self) -> str:
        """Return one line with the slack of each coordinate and the muscles at their limits."""
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
