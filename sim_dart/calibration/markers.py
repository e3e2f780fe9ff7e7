"""Motion-capture markers on links: positions at a pose, and poses from marker positions.

A marker at u in its link frame is at p(q) = o(q) + R(q) u in the world. The C core computes the
origin o and the points o + R e_a on the axes. p and dp/dq are linear combinations of these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from threading import Lock

import numpy as np

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from addin_sdfusion.robot.model.robot import TaskFrame, TaskSet
from sim_dart.core.arrays import FloatArray, IntArray
from sim_dart.muscles.paths import MusclePaths

_ITERATIONS = 20
_SETTLED = 1e-9
_STARTS = 32
_SEED = 0

_FAR = 0.05
"""RMS distance, in [m], above which markers contradict their positions in the table."""

_MAX_VALUE = 1e100
"""Largest value that is accepted, so that squares do not overflow."""

_SEEN = 1e-3
"""Smallest accepted singular value of the marker Jacobian, in [m/rad] or [m/m]."""


@dataclass(frozen=True)
class Marker:
    """Marker on a link.

    Attributes:
        position: Position in the link frame, in [m].
    """

    name: str
    link: str
    position: tuple[float, float, float]


class MarkerKinematics:
    """Kinematics of M markers of a robot in the world frame.

    Raises:
        UnknownNameError: The link of a marker does not exist.

    Attributes:
        positions: Positions in their link frames, shape (M, 3), in [m].
    """

    def __init__(self, robot: Robot, markers: Sequence[Marker]) -> None:
        links = [link.name for link in robot.links]
        for one in markers:
            if one.link not in links:
                raise UnknownNameError("link", one.link, links, key=f"{one.name}.link")
        self.markers = tuple(markers)
        self.positions = np.array([one.position for one in markers]).reshape(-1, 3)
        worn = list(dict.fromkeys(one.link for one in markers))
        self._link = np.array([worn.index(one.link) for one in markers], dtype=np.int32)
        ends = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
        points = [
            TaskFrame(f"{link}_{k}", link, end) for link in worn for k, end in enumerate(ends)
        ]
        tasks = TaskSet("markers", tuple(points))
        self._paths = MusclePaths(replace(robot, task_sets=(tasks,), task_set=tasks.name))
        self._n, self._points, self._lock = len(robot.coordinates), 12 * len(worn), Lock()

    def at(self, q: FloatArray, positions: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Compute marker positions at several poses.

        Args:
            q: Poses, shape (rows, n), in [rad] or [m].
            positions: Positions in the link frames, shape (M, 3), in [m].

        Returns:
            p, shape (rows, 3 M), dp/dq, shape (rows, 3 M, n), and R, shape (rows, M, 3, 3).
        """
        rows, M, n = len(q), len(self.markers), self._n
        y, J = np.empty((rows, self._points)), np.empty((rows, self._points, n))
        with self._lock:  # a core has only one pose at a time
            for k, pose in enumerate(q):
                J[k] = self._paths.task_jacobian(pose)
                y[k] = self._paths.task_position(pose)
        points = y.reshape(rows, -1, 4, 3)[:, self._link]
        slopes = J.reshape(rows, -1, 4, 3, n)[:, self._link]
        weights = np.column_stack([1.0 - positions.sum(axis=1), positions])
        p = np.einsum("mk,rmka->rma", weights, points)
        dp = np.einsum("mk,rmkan->rman", weights, slopes)
        R = np.swapaxes(points[:, :, 1:] - points[:, :, :1], 2, 3)
        return p.reshape(rows, 3 * M), dp.reshape(rows, 3 * M, n), R


def poses_from_markers(
    seen: MarkerKinematics, robot: Robot, q: FloatArray, markers: FloatArray
) -> FloatArray:
    """Compute poses from marker positions by least squares, row by row.

    Args:
        q: Encoder positions, NaN if not measured, shape (K, n).
        markers: Measured marker positions, NaN if hidden, shape (K, 3 M), in [m].

    Returns:
        q, completed by the poses from markers; NaN if the visible markers do not determine it.

    Raises:
        InputError: The markers do not determine any pose, or contradict the robot.
    """
    blind = np.flatnonzero(np.isnan(q).all(axis=0)).astype(np.int32)
    poses, start = q.copy(), None
    if not len(blind):
        return poses
    measured = np.flatnonzero(~np.isnan(q).all(axis=0))
    left: list[float] = []
    weakest = (np.inf, -1)
    for k in np.flatnonzero(~np.isnan(markers).all(axis=1)):
        if np.isnan(q[k, measured]).any():
            continue
        pose = q[k].copy()
        if start is None:
            fit = _search_pose(seen, robot, pose, blind, markers[k])
        else:
            pose[blind] = start
            fit = _fit_pose(seen, pose, blind, markers[k])
        weakest = min(weakest, fit.weakest)
        if fit.weakest[0] < _SEEN:
            continue
        start = fit.pose[blind]
        poses[k] = fit.pose
        left.append(fit.rms)
    if not left:
        names = [c.name for c in robot.coordinates]
        which = names[weakest[1]] if weakest[1] >= 0 else ", ".join(names[j] for j in blind)
        raise InputError(f"the markers do not determine {which}; add markers on the links it moves")
    if np.median(left) > _FAR:
        raise InputError(
            f"the markers are {1e3 * float(np.median(left)):.0f} mm away from any position that "
            "the robot can reach; check their links, and that positions are in m in the world frame"
        )
    return poses


@dataclass(frozen=True)
class _Pose:
    """Pose from markers, with residual and smallest singular value of the Jacobian."""

    pose: FloatArray
    rms: float
    weakest: tuple[float, int]


def _search_pose(
    seen: MarkerKinematics, robot: Robot, pose: FloatArray, blind: IntArray, y: FloatArray
) -> _Pose:
    """Return the best fit from several start poses within the joint limits."""
    rng = np.random.default_rng(_SEED)
    low = np.array([max(c.lower, -np.pi) for c in robot.coordinates])[blind]
    high = np.array([min(c.upper, np.pi) for c in robot.coordinates])[blind]
    initial = np.array([c.initial for c in robot.coordinates])[blind]
    tried = []
    for start in (initial, *rng.uniform(low, high, size=(_STARTS, len(blind)))):
        pose[blind] = start
        tried.append(_fit_pose(seen, pose, blind, y))
    return min(tried, key=lambda one: one.rms)


def _fit_pose(seen: MarkerKinematics, pose: FloatArray, blind: IntArray, y: FloatArray) -> _Pose:
    """Fit a pose from a start pose by the Levenberg-Marquardt method."""
    valid, pose, damping = ~np.isnan(y), pose.copy(), 1e-6

    def residual(at: FloatArray) -> tuple[FloatArray, FloatArray]:
        p, dp, _ = seen.at(at[None], seen.positions)
        return (y - p[0])[valid], dp[0][np.ix_(valid, blind)]

    r, J = residual(pose)
    if not _is_bounded(r, J):  # lengths of the robot are too large
        return _Pose(pose, np.inf, (0.0, int(blind[0])))
    for _ in range(_ITERATIONS):
        damped = np.sqrt(damping * (1.0 + (J**2).sum(axis=0)))
        rows = np.vstack([J, np.diag(damped)])
        step = np.linalg.lstsq(rows, np.concatenate([r, np.zeros(len(blind))]), rcond=None)[0]
        new = pose.copy()
        new[blind] += step
        new_r, new_J = residual(new)
        if new_r @ new_r > r @ r or not _is_bounded(new_r, new_J):
            damping *= 10.0
            continue
        pose, r, J, damping = new, new_r, new_J, damping / 10.0
        if np.abs(step).max() < _SETTLED:
            break
    _, values, axes = np.linalg.svd(J, full_matrices=True)
    least = float(values[-1]) if len(values) == len(blind) else 0.0
    weakest = (least, int(blind[np.argmax(np.abs(axes[-1]))]))
    return _Pose(pose, float(np.sqrt(np.mean(r**2))), weakest)


def _is_bounded(r: FloatArray, J: FloatArray) -> bool:
    return bool(np.abs(r).max() < _MAX_VALUE and np.abs(J).max() < _MAX_VALUE)
