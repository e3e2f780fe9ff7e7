"""Variables between bounds, with the multipliers of an interior-point method."""

from __future__ import annotations

import numpy as np

from controllers.arrays import FloatArray

_INSIDE = 1e-2  # smallest distance of the start from bounds, relative to the distance of the bounds
_MAX_STEP = 0.99  # share of the way to a bound
_MIN_DISTANCE = 1e-15  # from a bound, against rounding errors
_MAX_RATIO = 1e10  # of a multiplier and the barrier over the distance


class BoundedVariables:
    """Variables low < value < high, with multipliers of both bounds.

    Args:
        value: Start; values near or beyond bounds are moved inside.
        low: Lower bounds, of the same shape.
        high: Upper bounds, of the same shape.
        barrier: Weight of the logarithmic barrier.
    """

    def __init__(
        self, value: FloatArray, low: FloatArray, high: FloatArray, barrier: float
    ) -> None:
        margin = _INSIDE * (high - low)
        self._low, self._high = low, high
        self.value = np.clip(value, low + margin, high - margin)
        self._z_low, self._z_high = barrier / self.below, barrier / self.above

    @property
    def below(self) -> FloatArray:
        """Distance from the lower bounds."""
        return np.maximum(self.value - self._low, _MIN_DISTANCE)

    @property
    def above(self) -> FloatArray:
        """Distance from the upper bounds."""
        return np.maximum(self._high - self.value, _MIN_DISTANCE)

    @property
    def curvature(self) -> FloatArray:
        """Primal-dual curvature of the barrier."""
        return self._z_low / self.below + self._z_high / self.above

    @property
    def dual(self) -> FloatArray:
        """Gradient of the multipliers."""
        return self._z_high - self._z_low

    def slope(self, barrier: float) -> FloatArray:
        """Return the gradient of the barrier."""
        return barrier / self.above - barrier / self.below

    def error(self, barrier: float) -> float:
        """Return the largest error of complementarity."""
        errors = self._z_low * self.below - barrier, self._z_high * self.above - barrier
        return max(float(abs(error).max(initial=0.0)) for error in errors)

    def max_step(self, step: FloatArray) -> float:
        """Return the largest share of a step that stays inside."""
        return min(_max_share(self.below, step), _max_share(self.above, -step))

    def dual_steps(self, step: FloatArray, barrier: float) -> tuple[FloatArray, FloatArray]:
        """Return the steps of the multipliers for a step of the values."""
        low = (barrier - self._z_low * step) / self.below - self._z_low
        high = (barrier + self._z_high * step) / self.above - self._z_high
        return low, high

    def max_dual_step(self, steps: tuple[FloatArray, FloatArray]) -> float:
        """Return the largest share of steps that keeps the multipliers positive."""
        return min(_max_share(self._z_low, steps[0]), _max_share(self._z_high, steps[1]))

    def move(
        self,
        step: FloatArray,
        share: float,
        duals: tuple[FloatArray, FloatArray],
        dual_share: float,
        barrier: float,
    ) -> None:
        """Move values and multipliers by shares of their steps."""
        self.value = self.value + share * step
        near = barrier / _MAX_RATIO, barrier * _MAX_RATIO
        low, high = self._z_low + dual_share * duals[0], self._z_high + dual_share * duals[1]
        self._z_low = np.clip(low, near[0] / self.below, near[1] / self.below)
        self._z_high = np.clip(high, near[0] / self.above, near[1] / self.above)


def _max_share(distance: FloatArray, step: FloatArray) -> float:
    worst = float((-step / distance).max(initial=0.0))
    return min(1.0, _MAX_STEP / worst) if worst > 0.0 else 1.0
