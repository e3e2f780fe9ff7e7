"""Detection of diverged runs: values beyond any physical scale end the run with an error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import SimulationError
from cardsflow_fmu.utils.arrays import FloatArray

MAX_MOTION = 1.0
"""Maximum motion of a joint within a communication step, in [rad] or [m]."""
MAX_FORCE = 1e9
"""Maximum plausible muscle force, in [N]."""


class Divergence:
    """Checker for the rows of a run.

    Args:
        names: Names of the columns, `time` first.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self._names = names
        self._speeds = _columns(names, ("qd.",))
        self._forces = _columns(names, ("f.", "tension."))
        self._checked_rows = 0

    def check(self, rows: FloatArray) -> None:
        """Check the rows that have not been checked yet.

        Args:
            rows: All rows so far, shape (rows, len(names)).

        Raises:
            SimulationError: The run has diverged.
        """
        new = rows[self._checked_rows :]
        if len(new) == 0 or len(rows) < 2:
            return
        self._checked_rows = len(rows)
        step = float(rows[1, 0] - rows[0, 0])
        for columns, limit, scale, what in (
            (self._speeds, MAX_MOTION, step, "moves {:.3g} rad or m within a step"),
            (self._forces, MAX_FORCE, 1.0, "is {:.3g} N"),
        ):
            sizes = np.abs(new[:, columns]) * scale
            beyond = ~(sizes <= limit)
            if beyond.any():
                k = int(np.argmax(beyond.any(axis=1)))
                j = int(np.argmax(np.where(beyond[k], sizes[k], -1.0)))
                raise SimulationError(
                    f"the run has diverged: at t = {new[k, 0]:.6g} s "
                    f"{_display_name(self._names[columns[j]])} {what.format(sizes[k, j])}; use a "
                    "shorter controller.period and plant.step, smaller gains, or a motion that the "
                    "muscles can produce"
                )


def _columns(names: Sequence[str], prefixes: tuple[str, ...]) -> list[int]:
    return [k for k, name in enumerate(names) if name.startswith(prefixes)]


def _display_name(name: str) -> str:
    """Return a description of a column for messages."""
    kind, _, part = name.partition(".")
    return f"joint {part}" if kind == "qd" else f"the force of muscle {part}"
