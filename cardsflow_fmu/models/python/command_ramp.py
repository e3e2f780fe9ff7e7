"""Commands while an estimate is lost: down to the smallest ones, and back."""

from __future__ import annotations

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray


class CommandRamp:
    """The commands f = f_rest + s (f_law - f_rest) of a controller whose state may get lost.

    While it is lost, f_law stays the last one and s falls from 1 to 0 within `down`; once it is
    back, s rises within `up`.

    Args:
        down: In [s].
        up: In [s].
        start: Forces before the first tick, shape (a,), in [N] and [N·m].
        q: Positions at the start, shape (n,), in [rad] or [m].

    Attributes:
        q: Positions at the last tick with a state, shape (n,), in [rad] or [m].
    """

    def __init__(self, down: float, up: float, start: FloatArray, q: FloatArray) -> None:
        self._down, self._up = down, up
        self._share, self._law, self.q = 1.0, start.copy(), q.copy()

    def falling(self, period: float, rest: FloatArray) -> FloatArray:
        """The forces of a tick without a state.

        Args:
            period: In [s].
            rest: f_rest, shape (a,), in [N] and [N·m].
        """
        self._share = max(0.0, self._share - period / self._down) if self._down else 0.0
        return rest + self._share * (self._law - rest)

    def rising(self, period: float, rest: FloatArray, law: FloatArray, q: FloatArray) -> FloatArray:
        """The forces of a tick with a state.

        Args:
            period: In [s].
            rest: f_rest, shape (a,), in [N] and [N·m].
            law: f_law, likewise.
            q: Positions, shape (n,), in [rad] or [m].
        """
        self._law[:], self.q[:] = law, q
        if self._share < 1.0:
            self._share = min(1.0, self._share + period / self._up) if self._up else 1.0
        return law if self._share == 1.0 else rest + self._share * (law - rest)

    def get_state(self) -> FloatArray:
        """All that it remembers."""
        return np.concatenate([[self._share], self._law, self.q])

    def set_state(self, state: FloatArray) -> None:
        """Go back to a state from `get_state`."""
        a = self._law.size
        self._share, self._law[:], self.q[:] = float(state[0]), state[1 : 1 + a], state[1 + a :]
