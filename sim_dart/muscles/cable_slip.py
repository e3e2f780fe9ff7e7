"""Slip direction of cables with friction, derived from joint motion."""

from __future__ import annotations

import numpy as np

from sim_dart.core.arrays import FloatArray

from .paths import MusclePaths


class CableSlip:
    """Slip states s of the bends of a robot's cables, updated from joint positions.

    The slip direction changes with the displacement of the cable, over fractions of a millimetre,
    and not with the sign of its velocity. Measurement noise below this displacement does not
    change the direction.

    Args:
        paths: The muscle paths whose `pulling` uses the slip states.

    Attributes:
        states: Slip direction s of each bend, from -1 to 1, shape (bends,), as a view.
    """

    def __init__(self, paths: MusclePaths) -> None:
        self._paths, self._core = paths, paths.core
        count = paths.bends
        self.states = self._core.array("law_states", paths.law_states + count)[-count:]
        self._last: FloatArray | None = None
        self._n = paths.coordinates

    def reset(self) -> None:
        """Set all slip directions to 0."""
        self.states[:] = 0.0
        self._last = None

    def follow(self, q: FloatArray) -> None:
        """Update the slip states to new joint positions.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        self._paths.evaluate(q)
        if self._last is not None:
            self._core.slide(self._core.handle, (q - self._last).tobytes())
        self._last = np.array(q)

    def get_state(self) -> FloatArray:
        """Return the slip states, a flag whether a last position exists, and this position."""
        has_last = self._last is not None
        last = np.zeros(self._n) if self._last is None else self._last
        return np.concatenate([self.states, [float(has_last)], last])

    def set_state(self, state: FloatArray) -> None:
        """Restore a state from `get_state`."""
        count = self.states.size
        self.states[:] = state[:count]
        self._last = np.array(state[count + 1 :]) if state[count] else None
