"""Motion-capture markers on links: positions at a pose, and poses from marker positions.

A marker at u in its link frame is at p(q) = o(q) + R(q) u in the world. The C core computes the
origin o and the points o + R e_a on the axes. p and dp/dq are linear combinations of these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from threading import Lock

import numpy as np

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from sim_dart.core.arrays import FloatArray, IntArray
from sim_dart.dynamics.link_motion import LinkPoints

_ITERATIONS = 20
_MIN_CHANGE = 1e-9
_STARTS = 32
_SEED = 0

_MAX_DISTANCE = 0.05
"""RMS distance, in [m], above which markers contradict their positions in the table."""

_MAX_VALUE = 1e100
"""Largest value that is accepted, so that squares do not overflow."""

_MIN_SINGULAR = 1e-3
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
        marked = list(dict.fromkeys(one.link for one in markers))
        self._link = np.array([marked.index(one.link) for one in markers], dtype=np.int32)
        self._points, self._lock = LinkPoints(robot, marked), Lock()

    def at(self, q: FloatArray, positions: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Compute marker positions at several poses.

        Args:
            q: Poses, shape (rows, n), in [rad] or [m].
            positions: Positions in the link frames, shape (M, 3), in [m].

        Returns:
            p, shape (rows, 3 M), dp/dq, shape (rows, 3 M, n), and R, shape (rows, M, 3, 3).
        """
        rows, M = len(q), len(self.markers)
        with self._lock:  # a core has only one pose at a time
            points, slopes = (values[:, self._link] for values in self._points.at(q))
        weights = np.column_stack([1.0 - positions.sum(axis=1), positions])
        p = np.einsum("mk,rmka->rma", weights, points)
        dp = np.einsum("mk,rmkan->rman", weights, slopes)
        R = np.swapaxes(points[:, :, 1:] - points[:, :, :1], 2, 3)
        return p.reshape(rows, 3 * M), dp.reshape(rows, 3 * M, -1), R


def poses_from_markers(
    kinematics: MarkerKinematics, robot: Robot, q: FloatArray, markers: FloatArray
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
    unmeasured = np.flatnonzero(np.isnan(q).all(axis=0)).astype(np.int32)
    poses, start = q.copy(), None
    if not len(unmeasured):
        return poses
    measured = np.flatnonzero(~np.isnan(q).all(axis=0))
    distances: list[float] = []
    weakest = (np.inf, -1)
    for k in np.flatnonzero(~np.isnan(markers).all(axis=1)):
        if np.isnan(q[k, measured]).any():
            continue
        pose = q[k].copy()
        if start is None:
            fit = _search_pose(kinematics, robot, pose, unmeasured, markers[k])
        else:
            pose[unmeasured] = start
            fit = _fit_pose(kinematics, pose, unmeasured, markers[k])
        weakest = min(weakest, fit.weakest)
        if fit.weakest[0] < _MIN_SINGULAR:
            continue
        start = fit.pose[unmeasured]
        poses[k] = fit.pose
        distances.append(fit.rms)
    if not distances:
        names = [c.name for c in robot.coordinates]
        which = names[weakest[1]] if weakest[1] >= 0 else ", ".join(names[j] for j in unmeasured)
        raise InputError(f"the markers do not determine {which}; add markers on the links it moves")
    distance = float(np.median(distances))
    if distance > _MAX_DISTANCE:
        raise InputError(
            f"the markers are {1e3 * distance:.0f} mm away from any position that "
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
    kinematics: MarkerKinematics,
    robot: Robot,
    pose: FloatArray,
    unmeasured: IntArray,
    y: FloatArray,
) -> _Pose:
    """Return the best fit from several start poses within the joint limits."""
    rng = np.random.default_rng(_SEED)
    low = np.array([max(c.lower, -np.pi) for c in robot.coordinates])[unmeasured]
    high = np.array([min(c.upper, np.pi) for c in robot.coordinates])[unmeasured]
    initial = np.array([c.initial for c in robot.coordinates])[unmeasured]
    tried = []
    for start in (initial, *rng.uniform(low, high, size=(_STARTS, len(unmeasured)))):
        pose[unmeasured] = start
        tried.append(_fit_pose(kinematics, pose, unmeasured, y))
    return min(tried, key=lambda one: one.rms)


def _fit_pose(
    kinematics: MarkerKinematics, pose: FloatArray, unmeasured: IntArray, y: FloatArray
) -> _Pose:
    """Fit a pose from a start pose by the Levenberg-Marquardt method."""
    valid, pose, damping = ~np.isnan(y), pose.copy(), 1e-6

    def residual(at: FloatArray) -> tuple[FloatArray, FloatArray]:
        p, dp, _ = kinematics.at(at[None], kinematics.positions)
        return (y - p[0])[valid], dp[0][np.ix_(valid, unmeasured)]

    r, J = residual(pose)
    if not _is_bounded(r, J):  # lengths of the robot are too large
        return _Pose(pose, np.inf, (0.0, int(unmeasured[0])))
    for _ in range(_ITERATIONS):
        damped = np.sqrt(damping * (1.0 + (J**2).sum(axis=0)))
        rows = np.vstack([J, np.diag(damped)])
        step = np.linalg.lstsq(rows, np.concatenate([r, np.zeros(len(unmeasured))]), rcond=None)[0]
        new = pose.copy()
        new[unmeasured] += step
        new_r, new_J = residual(new)
        if new_r @ new_r > r @ r or not _is_bounded(new_r, new_J):
            damping *= 10.0
            continue
        pose, r, J, damping = new, new_r, new_J, damping / 10.0
        if np.abs(step).max() < _MIN_CHANGE:
            break
    _, values, axes = np.linalg.svd(J, full_matrices=True)
    least = float(values[-1]) if len(values) == len(unmeasured) else 0.0
    weakest = (least, int(unmeasured[np.argmax(np.abs(axes[-1]))]))
    return _Pose(pose, float(np.sqrt(np.mean(r**2))), weakest)


def _is_bounded(r: FloatArray, J: FloatArray) -> bool:
    return bool(np.abs(r).max() < _MAX_VALUE and np.abs(J).max() < _MAX_VALUE)
