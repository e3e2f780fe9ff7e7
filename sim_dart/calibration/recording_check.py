"""Check for recordings of another robot and swapped signals, based on muscle lengths."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.muscles.paths import MusclePaths

from .recordings import Recording

_MAX_LENGTH_ERROR = 0.1
"""Length difference, in [m], above which a recording is from another robot."""

_POSES = 200
_SUSPICIOUS = 5e-3
"""RMS length difference after removing the mean, in [m], that is too large for via points."""

_REMAINING = 0.25
"""Fraction of this difference that may remain after two signals are exchanged."""


def require_same_robot(robot: Robot, paths: MusclePaths, recording: Recording) -> None:
    """Reject recordings whose lengths belong to another robot, or whose signals look swapped.

    Raises:
        InputError: Lengths differ from the robot's by more than a constant.
    """
    rows = np.flatnonzero(~np.isnan(recording.poses).any(axis=1))
    rows = rows[:: max(1, len(rows) // _POSES)]
    q, measured = recording.poses[rows], recording.lengths[rows]
    modelled = _lengths(paths, q)
    for first, second, before, after in _find_swapped_signals(robot, paths, q, measured, modelled):
        raise InputError(
            f"{recording.name}: {first!r} and {second!r} look swapped: lengths differ from this "
            f"robot's by {1e3 * before:.3g} mm RMS, and by {1e3 * after:.3g} mm RMS if they are "
            "exchanged; exchange them in the recording or on the robot"
        )
    for muscle, differences in zip(robot.muscles, (measured - modelled).T, strict=True):
        valid = differences[~np.isnan(differences)]
        most = float(np.abs(valid - np.median(valid)).max()) if len(valid) else 0.0
        if not most <= _MAX_LENGTH_ERROR:
            raise InputError(
                f"{recording.name}: the length of {muscle.name!r} differs from this robot's by up "
                f"to {1e3 * most:.3g} mm after removing a constant offset; check that the "
                "recording is from this robot"
            )


def _find_swapped_signals(
    robot: Robot, paths: MusclePaths, q: FloatArray, measured: FloatArray, modelled: FloatArray
) -> Iterator[tuple[str, str, float, float]]:
    """Return the pairs of signals whose exchange explains the difference, with both differences."""
    off = _spread(measured - modelled)
    suspicious = np.flatnonzero(off > _SUSPICIOUS)
    for i, j in combinations(suspicious.tolist(), 2):
        crossed = _spread(measured[:, [j, i]] - modelled[:, [i, j]])
        if (crossed < _REMAINING * off[[i, j]]).all():
            first, second = (f"l.{robot.muscles[k].name}" for k in (i, j))
            yield first, second, _rms(off[[i, j]]), _rms(crossed)
    if not len(suspicious):
        return
    for i, j in combinations(range(q.shape[1]), 2):
        exchanged = q.copy()
        exchanged[:, [i, j]] = q[:, [j, i]]
        then = _spread(measured - _lengths(paths, exchanged))
        if (then[suspicious] < _REMAINING * off[suspicious]).all():
            first, second = (f"q.{robot.coordinates[k].name}" for k in (i, j))
            yield first, second, _rms(off[suspicious]), _rms(then[suspicious])


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _lengths(paths: MusclePaths, q: FloatArray) -> FloatArray:
    """Return the muscle lengths at every pose, shape (poses, m), in [m]."""
    return np.array([paths.evaluate(row).lengths.copy() for row in q]).reshape(len(q), -1)


@np.errstate(over="ignore", invalid="ignore")  # lengths can be invalid
def _spread(differences: FloatArray) -> FloatArray:
    """Return the standard deviation of each column; 0 for columns without values."""
    valid = ~np.isnan(differences)
    count = np.maximum(valid.sum(axis=0), 1)
    mean = np.where(valid, differences, 0.0).sum(axis=0) / count
    squares = np.where(valid, differences - mean, 0.0) ** 2
    return np.asarray(np.sqrt(squares.sum(axis=0) / count))
