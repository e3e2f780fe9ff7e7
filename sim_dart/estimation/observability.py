"""Observability of the pose of a robot: the rank of the Jacobian of its sensors."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.muscles.paths import MusclePaths

from .estimated_robot import passive_muscles
from .settings import EstimatorSettings

_RANK = 1e-6
"""Singular values below this fraction of the largest one are treated as zero."""


@dataclass(frozen=True)
class Observability:
    """Observability of K poses from one measurement of lengths and encoders.

    Attributes:
        sd: Standard deviation of each coordinate, shape (K, n), in [rad] or [m]; infinite if the
            coordinate is not observable.
        rank: Rank at each pose, shape (K,).
        critical: Smallest set of one or two muscles that make a pose unobservable if they are
            slack; empty if no such set exists.
    """

    sd: FloatArray
    rank: FloatArray
    critical: tuple[str, ...]

    @property
    def is_observable(self) -> bool:
        """Whether all poses are observable if all muscles are taut."""
        return bool((self.rank == self.sd.shape[1]).all())


def observability(robot: Robot, poses: FloatArray, settings: EstimatorSettings) -> Observability:
    """Compute the observability of poses from muscle lengths and encoders.

    IMUs are ignored. At rest they measure only the direction of gravity.

    Args:
        poses: Poses, shape (K, n), in [rad] or [m].
        settings: Settings with the sensor noise.

    Raises:
        InputError: No pose is given.
    """
    n, m = len(robot.coordinates), len(robot.muscles)
    if not len(poses):
        raise InputError("observability requires at least one pose")
    weights = _weights(settings.length_noise, m)
    weights[passive_muscles(robot)] = 0.0
    encoders = np.diag(_weights(settings.encoder_noise, n))
    paths = MusclePaths(robot)
    rows = np.array([paths.evaluate(q).jacobian * weights[:, None] for q in poses])
    results = [_rank_and_deviations(np.vstack([of_pose, encoders])) for of_pose in rows]
    return Observability(
        np.array([sd for _, sd in results]),
        np.array([rank for rank, _ in results]),
        _critical(robot, rows, encoders, weights),
    )


def _weights(noise: object, size: int) -> FloatArray:
    """Return 1/noise, and 0 for values that are not measured."""
    sd = np.broadcast_to(np.asarray(noise, dtype=float), size)
    measured = (sd > 0) & np.isfinite(sd)
    weights = np.zeros(size)
    weights[measured] = 1.0 / sd[measured]
    return weights


def _rank_and_deviations(J: FloatArray) -> tuple[int, FloatArray]:
    """Return the rank and the standard deviation of each coordinate."""
    _, s, V = np.linalg.svd(J, full_matrices=True)
    n = J.shape[1]
    s = np.concatenate([s, np.zeros(n - len(s))])
    seen = s > _RANK * max(s[0], 1e-300)
    open_to = (V[~seen] ** 2).sum(axis=0) > _RANK
    sd = np.sqrt(((V[seen] / s[seen, None]) ** 2).sum(axis=0))
    return int(seen.sum()), np.where(open_to, np.inf, sd)


def _critical(
    robot: Robot, rows: FloatArray, encoders: FloatArray, weights: FloatArray
) -> tuple[str, ...]:
    measured = np.flatnonzero(weights)
    n = encoders.shape[0]
    for count in (1, 2):
        for slack in combinations(measured, count):
            left = np.delete(rows, slack, axis=1)
            for of_pose in left:
                if _rank_and_deviations(np.vstack([of_pose, encoders]))[0] < n:
                    return tuple(robot.muscles[k].name for k in slack)
    return ()
