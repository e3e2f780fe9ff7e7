"""Readings for a calibration, from recordings of hardware and tables of runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.files import is_folder
from cardsflow_fmu.cosim.signals.hardware import MEASURED_TORQUE
from cardsflow_fmu.cosim.signals.muscles import driven_muscles, tension_signals
from cardsflow_fmu.cosim.signals.port import coordinate_signals, motor_signals, muscle_signals
from cardsflow_fmu.hardware.protocol.recording import (
    MISSED,
    is_recording,
    read_recording,
)
from cardsflow_fmu.results.files import RECORDING_FILE
from cardsflow_fmu.results.saved_run import read_results
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.calibration.markers import Marker
from sim_dart.calibration.readings import Readings
from sim_dart.estimation.estimated_robot import passive_muscles

from .markers import marker_names, read_capture, seen_at

_JITTER = 0.25
"""Of a step: times farther from equal steps are a gap, or no equal steps at all."""

_MAX_ROWS = 10_000_000

_MAX_VALUE = 1e9
"""In [m], [rad], [N] or [Nm]: least squares of larger readings are of these alone."""

_ACTING = ("tension", MEASURED_TORQUE)


def read_readings(
    path: Path, robot: Robot, markers: Sequence[Marker] = (), capture: Path | None = None
) -> Readings:
    """The readings of a recording: positions, lengths and tensions, or commanded forces.

    With markers, they are taken when these were seen.

    Args:
        path: A hardware.rec; a run's folder, its hardware.rec first, or its table; or any .csv or
            .parquet with `time`, `q.<joint>`, `l.<muscle>` and `f.<muscle>`, or `tension.<muscle>`.
        robot: The robot that it should be of.
        markers: Markers on it, whose `<marker>.x`, `.y` and `.z` are columns as well.
        capture: Another table that has these, with `time` by the same clock.

    Raises:
        InputError: It is none, was cut short, or is of another robot.
    """
    recorded = (
        path / RECORDING_FILE if is_folder(path) else path
    )  # states as they were when measured
    is_hardware = recorded.is_file() and is_recording(recorded)
    columns = _of_hardware(recorded) if is_hardware else _of_table(path)
    columns = {name: np.where(np.isnan(one), np.nan, one) for name, one in columns.items()}
    _require_same_names(path, columns, robot)  # NumPy warns of a signalling NaN, which is gone now
    t = columns["time"]
    if len(t) < 3:
        raise InputError(f"has {len(t)} readings: record for longer", file=path)
    at, step = _equal_steps(path, t)
    rows = int(at[-1]) + 1

    def block(names: Sequence[str], default: float = np.nan) -> FloatArray:
        found = np.full((rows, len(names)), np.nan)
        for k, name in enumerate(names):
            if name in columns:
                _refuse_large(path, name, columns)
                found[at, k] = columns[name]
            else:
                found[:, k] = default
        return found

    passive = passive_muscles(robot)
    tensions = block([_tension(own, columns) for own in _tension_names(robot)])
    tensions[:, passive] = 0.0
    lengths = block(muscle_signals("l", robot))
    lengths[:, passive] = np.nan
    torques = np.zeros((rows, len(robot.coordinates)))
    motors = motor_signals("tau", robot)
    driven = [k for k, c in enumerate(robot.coordinates) if c.actuated]
    if motors:
        torques[:, driven] = block(motors, 0.0)
    q = block(coordinate_signals("q", robot))
    readings = Readings(path.resolve().name, step, q, lengths, tensions, torques)
    if not markers:
        return readings
    if capture is not None:
        path, columns = capture, read_capture(capture)
    names = marker_names(markers)
    for name in names:
        if name not in columns:
            raise InputError(f"has no column {name!r}, of a marker, in m", file=path)
        _refuse_large(path, name, columns)
    seen = np.column_stack([columns[name] for name in names])
    shown = ~np.isnan(seen).all(axis=1)
    if shown.sum() < 3:
        raise InputError(f"shows markers {shown.sum()} times: record for longer", file=path)
    times, seen = columns["time"][shown], seen[shown]
    at, step = _equal_steps(path, times)
    filled = np.full((int(at[-1]) + 1, seen.shape[1]), np.nan)
    filled[at] = seen
    return seen_at(readings, float(t[0]), times[0] + step * np.arange(len(filled)), filled)


def _refuse_large(path: Path, name: str, columns: Mapping[str, FloatArray]) -> None:
    values, t = columns[name], columns["time"]
    large = np.flatnonzero(np.abs(values) > _MAX_VALUE)
    if len(large):
        what = f"{name} is {values[large[0]]:.3g} at {t[large[0]]:.6g} s, which is no reading"
        raise InputError(f"{what}: where one is lost, write nan", file=path)


def _tension_names(robot: Robot) -> list[tuple[str, ...]]:
    """Names that the tension of each muscle may have, the better first."""
    driven = set(driven_muscles(robot))
    rows = zip(
        tension_signals(robot),
        muscle_signals("tension", robot),
        muscle_signals("f", robot),
        strict=True,
    )
    return [
        (own, measured) if k in driven else (measured, commanded)
        for k, (own, measured, commanded) in enumerate(rows)
    ]


def _tension(names: Sequence[str], columns: Mapping[str, FloatArray]) -> str:
    return next((name for name in names if name in columns), names[0])


def _of_hardware(path: Path) -> dict[str, FloatArray]:
    """Columns of a hardware.rec: a state that came at a step's end is with the next command.

    Tensions and torques that it measured have acted up to then: those that act from then on are in
    the state behind it.
    """
    recording = read_recording(path)
    if recording.lost_bytes:
        raise InputError(
            f"was cut short or damaged after {len(recording)} records; record again", file=path
        )
    if len(recording) < 2:
        raise InputError(f"has {len(recording)} records: record for longer", file=path)
    header = recording.header
    states = np.where(((recording.flags & MISSED) != 0)[:, None], np.nan, recording.states)
    columns = {"time": recording.t[1:]}
    for k, name in enumerate(header.state_names):
        acts = name.partition(".")[0] in _ACTING
        columns[name] = states[1:, k] if acts else states[:-1, k]
    commands = zip(header.command_names, recording.commands[1:].T, strict=True)
    return columns | {name: one for name, one in commands if name not in columns}


def _of_table(path: Path) -> dict[str, FloatArray]:
    result = read_results(path)
    if result.summary.get("status", "complete") != "complete":
        raise InputError("is a run that did not come to its end; record again", file=path)
    return dict(zip(result.names, result.rows.T, strict=True))


def _require_same_names(path: Path, columns: Mapping[str, FloatArray], robot: Robot) -> None:
    """Refuse a recording of another robot, by its names.

    Raises:
        InputError: It has joints or muscles that the robot has not, or none of the robot's.
    """
    if "time" not in columns:
        raise InputError("has no column 'time'", file=path)
    known = {
        "q": set(coordinate_signals("q", robot)),
        "l": set(muscle_signals("l", robot)),
        "f": set(muscle_signals("f", robot)),
    }
    for kind, own in known.items():
        there = {name for name in columns if name.partition(".")[0] == kind and "." in name}
        unknown = sorted(there - own)
        if unknown:
            what = f"{unknown[0]!r} is no signal of robot {robot.name!r}: it is of another robot"
            raise InputError(what, file=path)
    if not any(name in columns for name in known["l"] | known["q"]):
        what = f"has neither positions nor lengths of robot {robot.name!r}, such as "
        raise InputError(f"{what}{min(known['q'] | known['l'])!r}", file=path)


def _equal_steps(path: Path, t: FloatArray) -> tuple[np.ndarray, float]:
    """Number of its step of each row, and the step, in [s]; rows that are missing leave a gap.

    Raises:
        InputError: Times do not increase, or by no equal steps.
    """
    differences = np.diff(t)
    if not np.isfinite(t).all() or (differences <= 0).any():
        row = int(np.argmax(~(differences > 0))) + 2
        raise InputError(f"row {row}: its time is not after that of the row before", file=path)
    step = float(np.median(differences))
    at = np.concatenate([[0], np.cumsum(np.maximum(np.rint(differences / step), 1))])
    whole = np.rint(differences / step)
    if (np.abs(differences / step - whole) > _JITTER).mean() > 0.01:
        raise InputError("its times are not equal steps, as a calibration needs", file=path)
    if at[-1] >= _MAX_ROWS:
        raise InputError(f"has gaps as long as {_MAX_ROWS} steps of {step:g} s", file=path)
    return at.astype(np.int64), step
