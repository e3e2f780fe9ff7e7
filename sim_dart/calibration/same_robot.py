"""Recordings that are of another robot, or whose signals are swapped, by lengths at known poses."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.muscles.paths import MusclePaths

from .readings import Readings

_OTHER_ROBOT = 0.1
"""Lengths that differ by more, in [m], are those of another robot."""

_POSES = 200
_SUSPICIOUS = 5e-3
"""RMS of lengths, in [m], less their mean, that no offset and hardly a via point explains."""

_EXPLAINED = 0.25
"""Remainder of it where two signals are swapped back."""


def require_this_robot(robot: Robot, paths: MusclePaths, readings: Readings) -> None:
    """Reject lengths that are another robot's, and signals that look swapped.

    Raises:
        InputError: They do not follow the robot's own, be they off by a constant.
    """
    rows = np.flatnonzero(~np.isnan(readings.poses).any(axis=1))
    rows = rows[:: max(1, len(rows) // _POSES)]
    q, measured = readings.poses[rows], readings.lengths[rows]
    own = _lengths(paths, q)
    for first, second, before, after in _swapped(robot, paths, q, measured, own):
        raise InputError(
            f"{readings.name}: {first!r} and {second!r} look swapped: lengths differ from this "
            f"robot's by {1e3 * before:.3g} mm RMS, and by {1e3 * after:.3g} mm RMS if they are "
            "exchanged; exchange them in the recording or on the robot"
        )
    for muscle, differences in zip(robot.muscles, (measured - own).T, strict=True):
        known = differences[~np.isnan(differences)]
        most = float(np.abs(known - np.median(known)).max()) if len(known) else 0.0
        if not most <= _OTHER_ROBOT:
            raise InputError(
                f"{readings.name}: the length of {muscle.name!r} differs from this robot's by up "
                f"to {1e3 * most:.3g} mm after removing a constant offset; check that the "
                "recording is from this robot"
            )


def _swapped(
    robot: Robot, paths: MusclePaths, q: FloatArray, measured: FloatArray, own: FloatArray
) -> Iterator[tuple[str, str, float, float]]:
    """Pairs whose exchange explains most of what lengths differ by, before and after."""
    off = _spread(measured - own)
    suspicious = np.flatnonzero(off > _SUSPICIOUS)
    for i, j in combinations(suspicious.tolist(), 2):
        crossed = _spread(measured[:, [j, i]] - own[:, [i, j]])
        if (crossed < _EXPLAINED * off[[i, j]]).all():
            first, second = (f"l.{robot.muscles[k].name}" for k in (i, j))
            yield first, second, _rms(off[[i, j]]), _rms(crossed)
    if not len(suspicious):
        return
    for i, j in combinations(range(q.shape[1]), 2):
        exchanged = q.copy()
        exchanged[:, [i, j]] = q[:, [j, i]]
        then = _spread(measured - _lengths(paths, exchanged))
        if (then[suspicious] < _EXPLAINED * off[suspicious]).all():
            first, second = (f"q.{robot.coordinates[k].name}" for k in (i, j))
            yield first, second, _rms(off[suspicious]), _rms(then[suspicious])


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _lengths(paths: MusclePaths, q: FloatArray) -> FloatArray:
    """At every pose, shape (poses, m)."""
    return np.array([paths.evaluate(row).lengths.copy() for row in q]).reshape(len(q), -1)


@np.errstate(over="ignore", invalid="ignore")  # of lengths that are none
def _spread(differences: FloatArray) -> FloatArray:
    """RMS less the mean, of each column; 0 of one that was never read."""
    known = ~np.isnan(differences)
    count = np.maximum(known.sum(axis=0), 1)
    mean = np.where(known, differences, 0.0).sum(axis=0) / count
    squares = np.where(known, differences - mean, 0.0) ** 2
    return np.asarray(np.sqrt(squares.sum(axis=0) / count))
