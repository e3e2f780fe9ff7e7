"""Results of a run: columns by port name, units, and a summary; written as CSV and JSON."""

from __future__ import annotations

import importlib.metadata
import json
import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import UnknownNameError

from .experiment import Experiment
from .master import COUPLING, Recording
from .ports import (
    Followed,
    followed_signals,
    identifier,
    muscle_signals,
    slack_signals,
)
from .version import __version__

FloatArray = NDArray[np.float64]

_BLOCK = 4096
TABLE = "results.csv"
UNITS = "results.units.json"
SUMMARY = "summary.json"


@dataclass
class Result:
    """What a run gave.

    Attributes:
        experiment: What was run.
        names: Name of every column; the first is `time`.
        rows: Values, shape (rows, len(names)).
        units: Unit of every column; empty for a number without one.
        summary: Tracking, forces, infeasible ticks, speed, status, versions.
        files: What was written, by its kind.
    """

    experiment: Experiment
    names: tuple[str, ...]
    rows: FloatArray
    units: Mapping[str, str]
    summary: dict[str, Any]
    files: dict[str, Path] = field(default_factory=dict)

    def __getitem__(self, name: str) -> FloatArray:
        """The column of that name, shape (rows,), in its unit.

        Raises:
            UnknownNameError: There is none; the message names the nearest.
        """
        if name not in self.names:
            prefix, _, rest = name.partition(".")
            cleaned = f"{prefix}.{identifier(rest)}" if rest else name
            if cleaned not in self.names:
                raise UnknownNameError("column", name, self.names)
            name = cleaned
        column: FloatArray = self.rows[:, self.names.index(name)]
        return column

    def columns(self, names: list[str]) -> FloatArray:
        """Several columns, shape (rows, len(names))."""
        return np.stack([self[name] for name in names], axis=1)

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return bool(self.summary["status"] == "complete")

    def contents(self) -> dict[str, str | bytes]:
        """The files of a result by name: table, units and summary."""
        return {
            TABLE: self._table(),
            UNITS: json.dumps(dict(self.units), indent=1) + "\n",
            SUMMARY: json.dumps(self.summary, indent=1) + "\n",
        }

    def describe(self) -> str:
        """A short summary for people, a line a topic."""
        summary = self.summary
        lines = [_title(summary), *_tracking_lines(summary), *_force_lines(summary)]
        lines += _infeasible_lines(summary)
        if summary["real_time_factor"] is not None:
            lines.append(
                f"speed       {summary['real_time_factor']:.1f} x real time, "
                f"first step after {summary['first_step_after_s']:.1f} s"
            )
        lines += [f"{kind:<14} {path}" for kind, path in sorted(self.files.items())]
        return "\n".join(lines)

    def _table(self) -> str:
        """The columns as CSV, every float such that it reads back exactly."""
        blocks = [",".join(self.names)]
        for first in range(0, len(self.rows), _BLOCK):  # as Python floats, all would be large
            rows = self.rows[first : first + _BLOCK].tolist()
            blocks.append("\n".join(",".join(map(repr, row)) for row in rows))
        return "\n".join(blocks) + "\n"


def summarize(
    experiment: Experiment, recording: Recording, wall_time: float, first_step_after: float
) -> dict[str, Any]:
    """The summary of a run.

    Args:
        experiment: What was run.
        recording: What the master recorded.
        wall_time: Time that the loop took, in [s].
        first_step_after: Time from the start of the program to the first step, in [s].
    """
    robot = experiment.robot
    columns = dict(zip(recording.names, recording.rows.T, strict=True))
    ticks = [k for k in recording.ticks if k < len(recording.rows)]
    infeasible = columns["infeasible"][ticks]
    simulated = float(columns["time"][-1]) if len(recording.rows) else 0.0
    failure = recording.failure
    return {
        "experiment": experiment.name,
        "robot": robot.name,
        "cable_set": robot.cable_set,
        "status": "complete" if failure is None else "incomplete",
        "error": None if failure is None else str(failure),
        "coupling": COUPLING,
        "duration": simulated,
        "step": experiment.run.step,
        "control_period": experiment.controller.period,
        "tracking": _tracking(experiment, columns),
        "forces": _forces(experiment, columns),
        "infeasible_ticks": int(np.count_nonzero(infeasible)),
        "ticks": len(recording.ticks),
        "slack": _slack(experiment, columns, ticks),
        "solve_time": _solve_time(recording.solve_times),
        "real_time_factor": simulated / wall_time if wall_time > 0 else None,
        "first_step_after_s": first_step_after,
        "warnings": experiment.warnings(),
        "versions": versions(),
    }


def tracking_errors(
    experiment: Experiment, columns: Mapping[str, FloatArray]
) -> tuple[Followed, FloatArray]:
    """What is followed, and the errors q - q_d or y - y_d, shape (rows, signals).

    Args:
        experiment: What was run.
        columns: Its columns by name.
    """
    followed = followed_signals(experiment.robot, experiment.reference.space)
    pairs = zip(followed.actual, followed.desired, strict=True)
    errors = np.stack([columns[a] - columns[b] for a, b in pairs], axis=1)
    turns = np.array(followed.turns)
    errors[:, turns] = np.remainder(errors[:, turns] + np.pi, 2.0 * np.pi) - np.pi
    return followed, errors


def _tracking(experiment: Experiment, columns: Mapping[str, FloatArray]) -> dict[str, Any]:
    """Root mean square over time of the errors' 2-norm, and the largest of all."""
    followed, errors = tracking_errors(experiment, columns)
    if not len(errors):
        return {"rms": None, "max": None, "unit": None, "per_signal": {}}
    units = set(followed.units)
    return {
        "rms": _rms(np.linalg.norm(errors, axis=1)),
        "max": float(np.abs(errors).max()),
        "unit": units.pop() if len(units) == 1 else "rad and m",
        "per_signal": {
            name: {
                "rms": _rms(errors[:, k]),
                "max": float(np.abs(errors[:, k]).max()),
                "unit": unit,
            }
            for k, (name, unit) in enumerate(zip(followed.actual, followed.units, strict=True))
        },
    }


def _slack(
    experiment: Experiment, columns: Mapping[str, FloatArray], ticks: list[int]
) -> dict[str, Any]:
    """What was missing at infeasible ticks: the largest by signal, how often, and when first."""
    infeasible = columns["infeasible"][ticks] != 0
    signals = slack_signals(experiment.robot, experiment.controller.space)
    missing = {name: np.abs(columns[name][ticks][infeasible]) for name in signals}
    times = columns["time"][ticks][infeasible]
    dropped = columns.get("limits_dropped", np.zeros(len(columns["time"])))
    return {
        "limits_dropped_ticks": int(np.count_nonzero(dropped[ticks])),
        "first_at_s": float(times[0]) if times.size else None,
        "last_at_s": float(times[-1]) if times.size else None,
        "per_signal": {
            name: {"max": float(values.max(initial=0.0)), "unit": signals[name]}
            for name, values in missing.items()
        },
    }


def _solve_time(seconds: list[float]) -> dict[str, Any]:
    """How long the controller took for a tick."""
    if not seconds:
        return {"median": None, "max": None, "unit": "s"}
    return {"median": float(np.median(seconds)), "max": max(seconds), "unit": "s"}


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _forces(experiment: Experiment, columns: Mapping[str, FloatArray]) -> dict[str, Any]:
    robot = experiment.robot
    names = muscle_signals("f", robot)
    if not len(columns["time"]):
        return {"min": None, "max": None, "unit": "N", "per_muscle": {}}
    values = np.stack([columns[name] for name in names])
    per_muscle = {
        name: {
            "min": float(columns[name].min()),
            "max": float(columns[name].max()),
            "f_min": muscle.f_min,
            "f_max": muscle.f_max if np.isfinite(muscle.f_max) else None,
        }
        for name, muscle in zip(names, robot.muscles, strict=True)
    }
    return {
        "min": float(values.min()),
        "max": float(values.max()),
        "unit": "N",
        "per_muscle": per_muscle,
    }


def _title(summary: Mapping[str, Any]) -> str:
    return (
        f"{summary['experiment']}: {summary['duration']:.6g} s, steps of {summary['step']:.6g} s, "
        f"control every {summary['control_period']:.6g} s, {summary['coupling']} coupling, "
        f"{summary['status']}"
    )


def _tracking_lines(summary: Mapping[str, Any]) -> list[str]:
    tracking = summary["tracking"]
    if tracking["rms"] is None:
        return []
    unit = tracking["unit"]
    lines = [f"tracking    RMS {tracking['rms']:.3g}, max {tracking['max']:.3g} {unit}"]
    lines += [
        f"  {name:<9} RMS {error['rms']:.3g}, max {error['max']:.3g} {error['unit']}"
        for name, error in tracking["per_signal"].items()
    ]
    return lines


def _force_lines(summary: Mapping[str, Any]) -> list[str]:
    forces = summary["forces"]
    if forces["min"] is None:
        return []
    lines = [f"forces      {forces['min']:.4g} to {forces['max']:.4g} N"]
    for name, muscle in forces["per_muscle"].items():
        upper = "unlimited" if muscle["f_max"] is None else f"{muscle['f_max']:.4g}"
        lines.append(
            f"  {name:<9} {muscle['min']:.4g} to {muscle['max']:.4g} N, "
            f"bounds {muscle['f_min']:.4g} to {upper}"
        )
    return lines


def _infeasible_lines(summary: Mapping[str, Any]) -> list[str]:
    lines = [f"infeasible  {summary['infeasible_ticks']} of {summary['ticks']} ticks"]
    slack = summary["slack"]
    if slack["first_at_s"] is not None:
        lines[0] += f", between {slack['first_at_s']:.6g} and {slack['last_at_s']:.6g} s, missing:"
        lines += [
            f"  {name.removeprefix('slack.'):<9} up to {missing['max']:.3g} {missing['unit']}"
            for name, missing in slack["per_signal"].items()
        ]
    if slack["limits_dropped_ticks"]:
        lines.append(f"  joint limits could not be kept at {slack['limits_dropped_ticks']} ticks")
    return lines


def versions() -> dict[str, str]:
    """Versions of what took part in a run."""
    packages = ("numpy", "scipy", "dartpy", "qpsolvers", "daqp", "fmpy")
    return {
        "cardsflow": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
    } | {package: importlib.metadata.version(package) for package in packages}
