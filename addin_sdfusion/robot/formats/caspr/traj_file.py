"""Reader of the .traj files of CASPR, which contain one sample of a trajectory per line."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

from ...errors import InputError
from ...files import read_file
from ...limits import TRAJECTORY
from ...model.trajectory import TrajectoryPoint
from ..reading.xml import NUMBER, short_repr
from .write_trajectories import TIME_TOLERANCE

WORDS = ("t", "p", "v", "a")
"""Words before the time, positions, velocities and accelerations of a sample."""


def read_samples(file: Path) -> tuple[float, tuple[TrajectoryPoint, ...]]:
    """Return the time step of a .traj file, in [s], and its samples.

    Raises:
        InputError: The file cannot be read, or its content is invalid.
    """
    lines = read_file(file, TRAJECTORY).decode("ascii", "replace").splitlines()
    word, _, step = lines[0].partition(",") if lines else ("", "", "")
    if word != "time_step":
        raise InputError("the first line must be 'time_step,<seconds>'", file=file, line=1)
    time_step = _number(step, file, 1)
    if time_step <= 0.0:
        raise InputError("time_step must be positive", file=file, line=1)
    while lines and not lines[-1].strip():
        lines.pop()
    points: list[TrajectoryPoint] = []
    for line, text in enumerate(lines[1:], start=2):
        point = _sample(text, file, line)
        _check_sample(point, points, time_step, file, line)
        points.append(point if points else TrajectoryPoint(0.0, point.q, point.qd, point.qdd))
    if len(points) < 2:
        raise InputError(f"must have at least two samples, not {len(points)}", file=file)
    return time_step, tuple(points)


def _check_sample(
    point: TrajectoryPoint, points: list[TrajectoryPoint], time_step: float, file: Path, line: int
) -> None:
    """Check that a sample is on the time grid and has the size of the first sample."""
    time = len(points) * time_step
    late = points and point.time <= points[-1].time
    if late or not abs(point.time - time) <= TIME_TOLERANCE:
        problem = f"time {point.time!r} s must be {time!r} s, a multiple of the time step"
        raise InputError(problem, file=file, line=line)
    size = len(points[0].q if points else point.q)
    for word, values in zip(WORDS[1:], (point.q, point.qd, point.qdd), strict=True):
        if len(values) != size:
            problem = f"{word!r} must have {size} numbers, not {len(values)}"
            raise InputError(problem, file=file, line=line)


def _sample(text: str, file: Path, line: int) -> TrajectoryPoint:
    tokens = text.strip().split(",")
    places = [i for i, token in enumerate(tokens) if token in WORDS]
    if tuple(tokens[i] for i in places) != WORDS or places[:2] != [0, 2]:
        problem = (
            f"{short_repr(text)} is not 't,<time>,p,<positions>,v,<velocities>,a,<accelerations>'"
        )
        raise InputError(problem, file=file, line=line)
    (time,), p, v, a = (
        tuple(_number(token, file, line) for token in tokens[start + 1 : end])
        for start, end in pairwise([*places, len(tokens)])
    )
    return TrajectoryPoint(time, p, v, a)


def _number(text: str, file: Path, line: int) -> float:
    text = text.strip(" \t")
    value = float(text) if NUMBER.fullmatch(text) else math.nan
    if not math.isfinite(value):
        raise InputError(f"{short_repr(text)} is not a finite number", file=file, line=line)
    return value
