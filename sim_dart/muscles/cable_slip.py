"""Slip direction of cables with friction, derived from joint motion."""

from __future__ import annotations

import numpy as np

from sim_dart.core.arrays import FloatArray

from .paths import MusclePaths


class CableSlip:
    """A copy of the states s of a robot's bends, which follows the joints.

    The direction of friction comes from the way that a cable has gone, over fractions of a
    millimetre, not from the sign of a rate: noise far below that way does not turn it.

    Args:
        paths: The paths whose `pulling` goes by it.
    """

    def __init__(self, paths: MusclePaths) -> None:
        self._paths, self._core = paths, paths.core
        count = paths.bends
        self._slips = self._core.array("law_states", paths.law_states + count)[-count:]
        self._last: FloatArray | None = None
        self._n = paths.coordinates

    @property
    def states(self) -> FloatArray:
        """Slip direction of each bend, s from -1 to 1, shape (bends,): a view."""
        return self._slips

    def reset(self) -> None:
        """Forget: neither way, anywhere."""
        self._slips[:] = 0.0
        self._last = None

    def lose(self) -> None:
        """Forget where the joints are, as when a state is lost: the next one is no way."""
        self._last = None

    def follow(self, q: FloatArray) -> None:
        """Go on to where the joints are now.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        self._paths.evaluate(q)
        if self._last is not None:
            self._core.slide(self._core.handle, (q - self._last).tobytes())
        self._last = np.array(q)

    def get_state(self) -> FloatArray:
        """Return the states, whether a position is known, and the position."""
        known = self._last is not None
        last = np.zeros(self._n) if self._last is None else self._last
        return np.concatenate([self._slips, [float(known)], last])

    def set_state(self, state: FloatArray) -> None:
        """Go back to a state from `get_state`."""
        count = self._slips.size
        self._slips[:] = state[:count]
        self._last = np.array(state[count + 1 :]) if state[count] else None
