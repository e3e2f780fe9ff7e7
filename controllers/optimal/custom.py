"""Base class of custom costs of optimal motions."""

from __future__ import annotations

from typing import NamedTuple

from controllers.arrays import FloatArray


class MotionState(NamedTuple):
    """State of a motion for a custom cost.

    Attributes:
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        y: Task coordinates, shape (k,), in [m] or [rad].
        yd: Their rates J qd, shape (k,).
        jacobian: Task Jacobian J = dy/dq, shape (k, n).
        fraction: Time as a fraction of the duration.
    """

    q: FloatArray
    qd: FloatArray
    y: FloatArray
    yd: FloatArray
    jacobian: FloatArray
    fraction: float


class MotionCost:
    """Custom cost: the integral of `running` over time, plus `final` at the end.

    A subclass defines one of them or both. It can also define `running_gradient(state)` and
    `final_gradient(state)`, which return the derivatives by q and qd, each of shape (n,). Without
    them, finite differences are used.
    """

    def running(self, state: MotionState) -> float:
        """Return the cost per second."""
        return 0.0

    def final(self, state: MotionState) -> float:
        """Return the cost of the end."""
        return 0.0
