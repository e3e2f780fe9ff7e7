"""What a controller needs to know of a robot: the terms of M(q) qdd + C + G = -L(q)^T f."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Dynamics(Protocol):
    """Dynamics of a robot with n coordinates and m muscles.

    Attributes:
        coordinate_names: n names, in the order of q.
        muscle_names: m names, in the order of f.
        f_min, f_max: Force bounds, shape (m,), in [N].
        damping: Viscous joint damping, shape (n,), in [N·m·s/rad] or [N·s/m].
    """

    @property
    def coordinate_names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def muscle_names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def f_min(self) -> FloatArray: ...  # noqa: D102
    @property
    def f_max(self) -> FloatArray: ...  # noqa: D102
    @property
    def damping(self) -> FloatArray: ...  # noqa: D102

    def mass_matrix(self, q: FloatArray) -> FloatArray:
        """M(q), shape (n, n)."""

    def coriolis(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        """C(q, qd), shape (n,)."""

    def gravity(self, q: FloatArray) -> FloatArray:
        """G(q), shape (n,)."""

    def muscle_jacobian(self, q: FloatArray) -> FloatArray:
        """L(q) = dl/dq, shape (m, n)."""
