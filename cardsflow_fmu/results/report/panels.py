"""Panels of figures by topic: forces, tracking, errors and more."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.cosim.signals.estimation import ESTIMATE
from cardsflow_fmu.cosim.signals.ports import coordinate_signals, identifier
from cardsflow_fmu.cosim.signals.tracked_signals import TrackedSignal, tracked_signals_by_name
from cardsflow_fmu.results.columns import chosen_columns
from cardsflow_fmu.results.run_data import ExperimentRunData, RunData
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.muscles.paths import MusclePaths

from .downsample import evenly_spaced

_MAX_VALUE = 1e100


@dataclass(frozen=True, eq=False)
class Curve:
    """Curve of a figure.

    Attributes:
        name: Name in the legend.
        time: Times, in [s], shape (points,).
        values: Values, shape (points,); nan for values that are not finite or too large to draw.
        of: For a reference, the name of its curve; otherwise empty.
        colour: Colour of a reference (default: colour of its curve).
    """

    name: str
    time: FloatArray
    values: FloatArray
    of: str = ""
    colour: str = ""

    def __post_init__(self) -> None:
        within = np.abs(self.values) < _MAX_VALUE
        if not within.all():
            object.__setattr__(self, "values", np.where(within, self.values, np.nan))


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves with common axes.

    Attributes:
        label: Label of the axis, with unit.
        curves: At least one curve.
        by_change: Whether curves are selected by change instead of magnitude.
        dotted: What the references are, for the legend.
    """

    label: str
    curves: list[Curve]
    by_change: bool = False
    dotted: str = "reference"


# for diverged runs
_ignore_overflow = np.errstate(over="ignore", invalid="ignore")


@_ignore_overflow
def panels_of(
    result: RunData, kinds: Sequence[str] = (), columns: Sequence[str] = ()
) -> list[Panel]:
    """Return the panels of a figure."""
    if not len(result.rows):
        raise InputError("the run has no rows")
    for kind in kinds:
        if kind not in KINDS:
            raise UnknownNameError("figure", kind, KINDS, key="--panels")
    panels = []
    for kind in kinds:
        panels_of_kind = KINDS[kind](result)
        if not panels_of_kind:
            raise InputError(f"the results have no data for {kind!r}", key="--panels")
        panels += panels_of_kind
    if columns:
        panels += _column_panels(result, columns)
    elif not kinds:
        panels = [panel for kind in _DEFAULT for panel in KINDS[kind](result)]
        panels = panels or _column_panels(result, ["*"])
    return panels


@_ignore_overflow
def all_panels(result: RunData) -> dict[str, list[Panel]]:
    """Return the panels of all kinds for which the result has data, by kind."""
    panels_by_kind = {kind: panels(result) for kind, panels in KINDS.items()}
    return {kind: panels for kind, panels in panels_by_kind.items() if panels}


def _column_panels(result: RunData, patterns: Sequence[str]) -> list[Panel]:
    """Return one panel per unit, or per prefix if the units are unknown."""
    groups: dict[str, list[str]] = {}
    for name in chosen_columns(result.names, patterns):
        groups.setdefault(result.units.get(name) or f"{name.split('.')[0]}", []).append(name)
    return [
        Panel(f"[{label}]" if result.units.get(names[0]) else label, _curves(result, names))
        for label, names in groups.items()
    ]


def _curves(result: RunData, names: Sequence[str]) -> list[Curve]:
    return [Curve(name, result["time"], result[name]) for name in names]


def _panels_with_prefix(
    prefix: str, label: str, by_change: bool = False
) -> Callable[[RunData], list[Panel]]:
    """Return a function that creates one panel per unit for all columns with a prefix."""

    def panels(result: RunData) -> list[Panel]:
        by_unit: dict[str, list[str]] = {}
        for name in result.names:
            if name.startswith(f"{prefix}."):
                by_unit.setdefault(result.units.get(name) or "-", []).append(name)
        return [
            Panel(f"{label} [{unit}]", _curves(result, names), by_change)
            for unit, names in by_unit.items()
        ]

    return panels


def _signals_by_unit(result: RunData) -> dict[str, list[TrackedSignal]]:
    """Return the controlled positions by unit."""
    by_unit: dict[str, list[TrackedSignal]] = {}
    for signal in tracked_signals_by_name(result.names, result.units):
        by_unit.setdefault(signal.unit or "-", []).append(signal)
    return by_unit


def tracking_curves(result: RunData, followed: Sequence[TrackedSignal]) -> list[Curve]:
    """Return curves of positions and their references."""
    time = result["time"]
    return [
        *_curves(result, [signal.actual for signal in followed]),
        *(Curve(f.desired, time, result[f.desired], of=f.actual, colour="black") for f in followed),
    ]


def _tracking(result: RunData) -> list[Panel]:
    by_unit = _signals_by_unit(result)
    return [
        Panel(f"position [{unit}]", tracking_curves(result, followed), by_change=True)
        for unit, followed in by_unit.items()
    ]


def _errors(result: RunData) -> list[Panel]:
    time, panels = result["time"], []
    for unit, followed in _signals_by_unit(result).items():
        errors = [(f.actual, f.error(result[f.actual], result[f.desired])) for f in followed]
        panels.append(Panel(f"error [{unit}]", [Curve(n, time, e) for n, e in errors]))
    return panels


def _estimates(result: RunData) -> list[Panel]:
    """Return panels of estimation errors with three standard deviations."""
    by_unit: dict[str, list[Curve]] = {}
    time = result["time"]
    for name in result.names:
        prefix, _, suffix = name.partition(".")
        truth, sd = f"q.{suffix}", f"{ESTIMATE['sd']}.{suffix}"
        if prefix != ESTIMATE["q"] or not {truth, sd} <= set(result.names):
            continue
        error, bound = result[name] - result[truth], 3.0 * result[sd]
        curves = by_unit.setdefault(result.units.get(truth) or "-", [])
        curves.append(Curve(name, time, error))
        curves.append(Curve(f"3 {sd}", time, bound, of=name, colour="black"))
    return [Panel(f"error of the estimate [{unit}]", curves) for unit, curves in by_unit.items()]


def _innovation(result: RunData) -> list[Panel]:
    names = [name for name in ("innovation", "valid") if name in result.names]
    return [Panel("innovation, validity", _curves(result, names))] if len(names) == 2 else []


def _solve_times(result: RunData) -> list[Panel]:
    times = result.solve_times
    curve = [Curve("controller", times[:, 0], 1e6 * times[:, 1])]
    return [Panel("computation time per tick [us]", curve)] if len(times) else []


def _moment_arms(result: RunData) -> list[Panel]:
    """Return panels of the moment arms -dl/dq of all muscles along the motion."""
    if not isinstance(result, ExperimentRunData):
        return []
    robot = result.experiment.robot
    signals = coordinate_signals("q", robot)
    if not set(signals) <= set(result.names):
        return []
    rows = evenly_spaced(len(result.rows), _POSES)
    time, paths = result["time"][rows], MusclePaths(robot)
    poses = result.columns(signals)[rows]
    is_finite = np.isfinite(poses).all(axis=1)
    if not is_finite.any():
        return []
    time = time[is_finite]
    arms = -np.stack([paths.evaluate(q).jacobian.copy() for q in poses[is_finite]])
    panels = []
    for j, coordinate in enumerate(robot.coordinates):
        acting = [k for k in range(len(robot.muscles)) if np.abs(arms[:, k, j]).max() > _MIN_ARM]
        curves = [Curve(identifier(robot.muscles[k].name), time, arms[:, k, j]) for k in acting]
        unit = "m" if coordinate.unit == "rad" else "1"
        panels += [Panel(f"moment arm, {coordinate.name} [{unit}]", curves)] if curves else []
    return panels


_POSES = 1000
_MIN_ARM = 1e-12
_DEFAULT = ("forces", "torques", "tracking", "errors", "estimate")

KINDS: dict[str, Callable[[RunData], list[Panel]]] = {
    "forces": _panels_with_prefix("f", "force command"),
    "torques": _panels_with_prefix("tau", "motor command"),
    "tracking": _tracking,
    "errors": _errors,
    "estimate": _estimates,
    "loads": _panels_with_prefix("w_hat", "estimated load"),
    "innovation": _innovation,
    "lengths": _panels_with_prefix("l", "muscle length", by_change=True),
    "moment_arms": _moment_arms,
    "solve_times": _solve_times,
    "slack": _panels_with_prefix("slack", "shortfall"),
}
"""Functions that create the panels of each kind; they return an empty list without data."""
