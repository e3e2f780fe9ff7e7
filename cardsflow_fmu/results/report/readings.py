"""Measurements for a calibration, from hardware recordings and results tables."""

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
from sim_dart.calibration.recordings import Recording
from sim_dart.estimation.estimated_robot import passive_muscles

from .markers import read_capture, resample

_JITTER = 0.25
"""Tolerance of equal steps, as fraction of a step."""

_MAX_ROWS = 10_000_000

_MAX_VALUE = 1e9
"""Maximum measurement, in [m], [rad], [N] or [N·m]; larger values would dominate the fit."""

_ACTING = ("tension", MEASURED_TORQUE)


def read_readings(
    path: Path, robot: Robot, markers: Sequence[Marker] = (), capture: Path | None = None
) -> Recording:
    """Read the measurements of a recording: positions, lengths, and tensions or commanded forces.

    With markers, the measurements are resampled at the times of motion capture.

    Args:
        path: A hardware.rec; a results folder (its hardware.rec, or its table); or a .csv
            with `time`, `q.<joint>`, `l.<muscle>` and `f.<muscle>` or `tension.<muscle>`.
        markers: Markers with columns `<marker>.x`, `.y` and `.z`.
        capture: Separate table of the markers, with the same time base.

    Raises:
        InputError: The recording is invalid, truncated, or of another robot.
    """
    recorded = (
        path / RECORDING_FILE if is_folder(path) else path
    )  # states with the time of measurement
    is_hardware = recorded.is_file() and is_recording(recorded)
    columns = _hardware_columns(recorded) if is_hardware else _table_columns(path)
    # replace signalling NaNs, which cause warnings of NumPy
    columns = {name: np.where(np.isnan(one), np.nan, one) for name, one in columns.items()}
    _require_same_names(path, columns, robot)
    t = columns["time"]
    if len(t) < 3:
        raise InputError(f"has only {len(t)} measurements; record for a longer time", file=path)
    at, step = _equal_steps(path, t)
    rows = int(at[-1]) + 1

    def block(names: Sequence[str], default: float = np.nan) -> FloatArray:
        block_rows = np.full((rows, len(names)), np.nan)
        for k, name in enumerate(names):
            if name in columns:
                _reject_large_values(path, name, columns)
                block_rows[at, k] = columns[name]
            else:
                block_rows[:, k] = default
        return block_rows

    passive = passive_muscles(robot)
    tensions = block([_tension(column_names, columns) for column_names in _tension_names(robot)])
    tensions[:, passive] = 0.0
    lengths = block(muscle_signals("l", robot))
    lengths[:, passive] = np.nan
    torques = np.zeros((rows, len(robot.coordinates)))
    motors = motor_signals("tau", robot)
    driven = [k for k, c in enumerate(robot.coordinates) if c.actuated]
    if motors:
        torques[:, driven] = block(motors, 0.0)
    q = block(coordinate_signals("q", robot))
    readings = Recording(path.resolve().name, step, q, lengths, tensions, torques)
    if not markers:
        return readings
    if capture is not None:
        path, columns = capture, read_capture(capture)
    return _with_markers(readings, float(t[0]), path, columns, markers)


def _with_markers(
    readings: Recording,
    begin: float,
    path: Path,
    columns: Mapping[str, FloatArray],
    markers: Sequence[Marker],
) -> Recording:
    """Return measurements from the time `begin`, resampled at the times of motion capture."""
    names = [f"{marker.name}.{axis}" for marker in markers for axis in "xyz"]
    for name in names:
        if name not in columns:
            raise InputError(f"has no column {name!r} of a marker (position in m)", file=path)
        _reject_large_values(path, name, columns)
    positions = np.column_stack([columns[name] for name in names])
    is_complete = ~np.isnan(positions).all(axis=1)
    if is_complete.sum() < 3:
        raise InputError(
            f"has markers at only {is_complete.sum()} times; record for a longer time", file=path
        )
    times, positions = columns["time"][is_complete], positions[is_complete]
    at, step = _equal_steps(path, times)
    filled = np.full((int(at[-1]) + 1, positions.shape[1]), np.nan)
    filled[at] = positions
    return resample(readings, begin, times[0] + step * np.arange(len(filled)), filled)


def _reject_large_values(path: Path, name: str, columns: Mapping[str, FloatArray]) -> None:
    """Reject a column with values above the maximum."""
    values, t = columns[name], columns["time"]
    large = np.flatnonzero(np.abs(values) > _MAX_VALUE)
    if len(large):
        problem = f"{name} is {values[large[0]]:.3g} at {t[large[0]]:.6g} s, which is not plausible"
        raise InputError(f"{problem}; write nan for a missing measurement", file=path)


def _tension_names(robot: Robot) -> list[tuple[str, ...]]:
    """Return possible column names of the muscle tensions, the preferred name first."""
    driven = set(driven_muscles(robot))
    rows = zip(
        tension_signals(robot),
        muscle_signals("tension", robot),
        muscle_signals("f", robot),
        strict=True,
    )
    return [
        (estimated, measured) if k in driven else (measured, commanded)
        for k, (estimated, measured, commanded) in enumerate(rows)
    ]


def _tension(names: Sequence[str], columns: Mapping[str, FloatArray]) -> str:
    return next((name for name in names if name in columns), names[0])


def _hardware_columns(path: Path) -> dict[str, FloatArray]:
    """Return the columns of a hardware.rec.

    The state at the end of a step is in the next row. Measured tensions and torques of a state
    acted during the step before its time. The values during the next step are in the next state.
    """
    recording = read_recording(path)
    if recording.lost_bytes:
        raise InputError(
            f"was cut short or damaged after {len(recording)} records; record it again", file=path
        )
    if len(recording) < 2:
        raise InputError(f"has only {len(recording)} records; record for a longer time", file=path)
    header = recording.header
    states = np.where(((recording.flags & MISSED) != 0)[:, None], np.nan, recording.states)
    columns = {"time": recording.t[1:]}
    for k, name in enumerate(header.state_names):
        acts = name.partition(".")[0] in _ACTING
        columns[name] = states[1:, k] if acts else states[:-1, k]
    commands = zip(header.command_names, recording.commands[1:].T, strict=True)
    return columns | {name: one for name, one in commands if name not in columns}


def _table_columns(path: Path) -> dict[str, FloatArray]:
    result = read_results(path)
    if result.summary.get("status") == "incomplete":
        raise InputError("is an incomplete run; record it again", file=path)
    return dict(zip(result.names, result.rows.T, strict=True))


def _require_same_names(path: Path, columns: Mapping[str, FloatArray], robot: Robot) -> None:
    """Check by names that a recording is of the robot."""
    if "time" not in columns:
        raise InputError("has no column 'time'", file=path)
    expected = {
        "q": set(coordinate_signals("q", robot)),
        "l": set(muscle_signals("l", robot)),
        "f": set(muscle_signals("f", robot)),
    }
    for kind, signals in expected.items():
        names = {name for name in columns if name.partition(".")[0] == kind and "." in name}
        unknown = sorted(names - signals)
        if unknown:
            problem = f"{unknown[0]!r} is not a signal of robot {robot.name!r}"
            raise InputError(f"{problem}; it is of another robot", file=path)
    if not any(name in columns for name in expected["l"] | expected["q"]):
        problem = f"has neither positions nor lengths of robot {robot.name!r}, such as "
        raise InputError(f"{problem}{min(expected['q'] | expected['l'])!r}", file=path)


def _equal_steps(path: Path, t: FloatArray) -> tuple[np.ndarray, float]:
    """Return the step number of each row and the step, in [s]; missing rows are gaps."""
    differences = np.diff(t)
    if not np.isfinite(t).all() or (differences <= 0).any():
        row = int(np.argmax(~(differences > 0))) + 2
        raise InputError(f"row {row}: the times must increase", file=path)
    step = float(np.median(differences))
    at = np.concatenate([[0], np.cumsum(np.maximum(np.rint(differences / step), 1))])
    steps = np.rint(differences / step)
    if (np.abs(differences / step - steps) > _JITTER).mean() > 0.01:
        raise InputError("a calibration requires times with equal steps", file=path)
    if at[-1] >= _MAX_ROWS:
        raise InputError(f"has gaps of more than {_MAX_ROWS} steps of {step:g} s", file=path)
    return at.astype(np.int64), step
