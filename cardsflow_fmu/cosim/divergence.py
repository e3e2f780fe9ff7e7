"""Last rows of bad runs: values that are not finite, or beyond any physical scale."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import SimulationError
from cardsflow_fmu.utils.arrays import FloatArray

MAX_MOTION = 1.0
"""Maximum motion of a joint within a communication step, in [rad] or [m]."""
MAX_FORCE = 1e9
"""Maximum plausible muscle force, in [N]."""


def column_limits(names: Sequence[str], step: float) -> list[float]:
    """Return the largest absolute value of each column; the largest finite number if unlimited.

    Args:
        names: Names of the columns, `time` first.
        step: Communication step, in [s].
    """
    return [_limit(name, step) for name in names]


def row_error(names: Sequence[str], row: FloatArray, step: float) -> SimulationError | None:
    """Return the error that a row shows, or None. A value that is not finite has priority.

    Args:
        names: Names of the columns, `time` first.
        row: Values, shape (len(names),).
        step: Communication step, in [s].
    """
    return not_finite_error(names, row) or _divergence(names, row, step)


def not_finite_error(names: Sequence[str], row: FloatArray) -> SimulationError | None:
    """Return the error of the first value that is not finite, or None; arguments as above."""
    bad = np.flatnonzero(~np.isfinite(row))
    if not bad.size:
        return None
    return SimulationError(not_finite_message(names[bad[0]], row[bad[0]], row[0]))


def not_finite_message(name: str, value: float, t: float) -> str:
    """Return the message about a value that is not finite."""
    return f"{name} is not finite at t = {t:.6g} s: {value}"


def _divergence(names: Sequence[str], row: FloatArray, step: float) -> SimulationError | None:
    limits = np.array(column_limits(names, step))
    excess = np.abs(row) / limits
    for kind, event in ((_SPEEDS, "moves {:.3g} rad or m within a step"), (_FORCES, "is {:.3g} N")):
        named = [k for k, name in enumerate(names) if name.startswith(kind)]
        columns = [k for k in named if abs(row[k]) > limits[k]]
        if columns:
            k = max(columns, key=lambda k: float(excess[k]))
            size = abs(row[k]) * (step if kind is _SPEEDS else 1.0)
            return SimulationError(
                f"the run has diverged: at t = {row[0]:.6g} s "
                f"{_display_name(names[k])} {event.format(size)}; use a shorter controller.period "
                "and plant.step, smaller gains, or a motion that the muscles can produce"
            )
    return None


_SPEEDS, _FORCES = ("qd.",), ("f.", "tension.")


def _limit(name: str, step: float) -> float:
    if name.startswith(_SPEEDS):
        return MAX_MOTION / step
    return MAX_FORCE if name.startswith(_FORCES) else sys.float_info.max


def _display_name(name: str) -> str:
    """Return a description of a column for messages."""
    kind, _, item = name.partition(".")
    return f"joint {item}" if kind == "qd" else f"the force of muscle {item}"
