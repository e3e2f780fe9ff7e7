"""Signals that track a reference: joint positions or task coordinates."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.utils.arrays import FloatArray

from .ports import coordinate_signals, task_signals, task_units


@dataclass(frozen=True, slots=True)
class TrackedSignal:
    """Signal that tracks a desired signal.

    Attributes:
        unit: Unit of both signals; empty if unknown.
        turns: Whether they are angles modulo 2 pi.
    """

    actual: str
    desired: str
    unit: str
    turns: bool

    def error(self, actual: FloatArray, desired: FloatArray) -> FloatArray:
        """Return the errors q - q_d or y - y_d of the columns, shape (rows,)."""
        error = actual - desired
        return np.remainder(error + np.pi, 2.0 * np.pi) - np.pi if self.turns else error


def tracked_signals(
    robot: Robot, space: Space, passive: Sequence[bool] = ()
) -> list[TrackedSignal]:
    """Return the positions that track a reference.

    Args:
        space: Whether the reference is in joint or operational space.
        passive: Whether each coordinate is passive, or empty if no coordinate is.
    """
    if space == "joint":
        names, prefixes = coordinate_signals, ("q", "q_d")
        units: list[str] = [c.unit for c in robot.coordinates]
    else:
        names, prefixes, units = task_signals, ("y", "y_d"), task_units(robot)
    rows = zip(*(names(prefix, robot) for prefix in prefixes), units, strict=True)
    signals = [TrackedSignal(a, d, unit, space != "joint" and unit == "rad") for a, d, unit in rows]
    return [signal for k, signal in enumerate(signals) if not (passive and passive[k])]


def tracked_signals_by_name(names: Sequence[str], units: Mapping[str, str]) -> list[TrackedSignal]:
    """Return the positions that have a desired position, such as `q.elbow` and `q_d.elbow`."""
    name_set = set(names)
    return [
        TrackedSignal(
            name, desired, units.get(name, ""), name[0] == "y" and units.get(name) == "rad"
        )
        for name in names
        if name.startswith(("q.", "y.")) and (desired := f"{name[0]}_d{name[1:]}") in name_set
    ]


def tracking_unit(signals: Iterable[TrackedSignal]) -> str:
    """Return the unit of the norm of all errors, or `rad and m` if the units differ."""
    units = {signal.unit for signal in signals}
    return units.pop() if len(units) == 1 else "rad and m"
