"""Smallest distances between muscles, and between muscles and links."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.checks.check import require_valid
from sim_dart.core.arrays import FloatArray
from sim_dart.core.frames import transform
from sim_dart.muscles.paths import MusclePaths
from sim_dart.scene import Box, Capsule, Cylinder, Scene, Shape, Sphere

from .link_shapes import link_shapes
from .meshes import convex_hull
from .skeleton import build_skeleton

_SAME = 1e-9  # in [m]; end points at a smaller distance are treated as equal
_NARROWINGS = 40
_FACES = 64  # of the prism that replaces a cylinder and exceeds its radius by up to 0.12 %


class Nearest(NamedTuple):
    """Smallest distance of a muscle from another muscle or a link.

    Attributes:
        other: Name of the other muscle or link.
        is_link: Whether `other` is a link.
        distance: Smallest distance, in [m]; negative if the muscle is inside of the link.
        sample: Index of the posture with the smallest distance.
    """

    muscle: str
    other: str
    is_link: bool
    distance: float
    sample: int


class Interference:
    """Distances between the muscles and links of a robot.

    A muscle is compared with all links that have none of its via points. Muscles without a path,
    whose length is only a function of coordinates, are skipped. The shape of a link consists of
    the convex hulls of its collision meshes and its collision shapes, or of capsules from joint to
    joint.

    Args:
        robot: The robot. Its active cable set is used.
        scene: Scene with the collision shapes of the links.

    Raises:
        RobotError: The robot is not valid.
        InputError: A mesh cannot be used.
    """

    def __init__(self, robot: Robot, scene: Scene) -> None:
        require_valid(robot)
        self._robot = robot
        self._paths = MusclePaths(robot)
        self._solids = [
            (shape.link, _Solid(shape.shape, transform(shape.pose)))
            for shape in link_shapes(robot, scene)
        ]
        self._skeleton = build_skeleton(robot) if self._solids else None
        self._links_of = [{point.link for point in muscle.via_points} for muscle in robot.muscles]

    def nearest(self, postures: Iterable[FloatArray], within: float = np.inf) -> list[Nearest]:
        """Return the smallest distance of every pair over all postures.

        Args:
            postures: Joint positions, each of shape (n,), in [rad] or [m].
            within: Distance in [m] above which pairs may be omitted, which is faster.
        """
        nearest: dict[tuple[str, str], Nearest] = {}
        for sample, q in enumerate(postures):
            segments = _Segments.of(self._paths.path_points(q))
            pairs = self._muscles(segments, sample, within)
            for near in (*pairs, *self._links(q, segments, sample, within)):
                previous = nearest.get((near.muscle, near.other))
                if previous is None or near.distance < previous.distance:
                    nearest[near.muscle, near.other] = near
        return sorted(nearest.values(), key=lambda near: near.distance)

    def _muscles(self, segments: _Segments, sample: int, within: float) -> Iterator[Nearest]:
        owners, starts, ends = segments
        i, j = _pairs_within(starts, ends, within)
        other = owners[i] != owners[j]
        i, j = i[other], j[other]
        apart = segment_distances(starts[i], ends[i], starts[j], ends[j])
        apart[_share_an_end(starts[i], ends[i], starts[j], ends[j])] = np.inf
        count = len(self._robot.muscles)
        smallest = np.full(count * count, np.inf)
        np.minimum.at(smallest, owners[i] * count + owners[j], apart)
        names = [muscle.name for muscle in self._robot.muscles]
        for k in np.flatnonzero(np.isfinite(smallest)):
            yield Nearest(names[k // count], names[k % count], False, float(smallest[k]), sample)

    def _links(
        self, q: FloatArray, segments: _Segments, sample: int, within: float
    ) -> Iterator[Nearest]:
        if self._skeleton is None:
            return
        self._skeleton.set_positions(q)
        names = [muscle.name for muscle in self._robot.muscles]
        for link, solid in self._solids:
            T_world_link = self._skeleton.bodies[link].getWorldTransform().matrix()
            others = np.array([link not in links for links in self._links_of], dtype=bool)
            owners, starts, ends = segments.of_muscles(others)
            smallest = np.full(len(names), np.inf)
            np.minimum.at(smallest, owners, solid.distances(T_world_link, starts, ends, within))
            for k in np.flatnonzero(np.isfinite(smallest)):
                yield Nearest(names[k], link, True, float(smallest[k]), sample)


class _Segments(NamedTuple):
    """Straight segments of all muscles.

    Attributes:
        owners: Index of the muscle of each segment.
        starts, ends: End points in the world frame, each of shape (k, 3), in [m].
    """

    owners: NDArray[np.intp]
    starts: FloatArray
    ends: FloatArray

    @staticmethod
    def of(lines: list[FloatArray]) -> _Segments:
        """Return the segments of the path points of all muscles."""
        owners = np.repeat(np.arange(len(lines)), [max(len(line) - 1, 0) for line in lines])
        starts = np.concatenate([line[:-1] for line in lines] or [np.empty((0, 3))])
        ends = np.concatenate([line[1:] for line in lines] or [np.empty((0, 3))])
        return _Segments(owners, starts, ends)

    def of_muscles(self, which: NDArray[np.bool_]) -> _Segments:
        """Return the segments of some muscles."""
        chosen = which[self.owners]
        return _Segments(self.owners[chosen], self.starts[chosen], self.ends[chosen])


class _Solid:
    """Shape for distance queries. A cylinder is replaced by a circumscribed prism."""

    def __init__(self, shape: Shape, T_link_shape: FloatArray) -> None:
        self._T_link_shape = T_link_shape
        self._radius = 0.0
        self._normals, self._offsets = np.empty((0, 3)), np.empty(0)
        if isinstance(shape, Capsule):
            self._radius = shape.radius
            self._end = np.array([0.0, 0.0, 0.5 * shape.length])
        elif isinstance(shape, Sphere):
            self._radius, self._end = shape.radius, np.zeros(3)
        elif isinstance(shape, Box):
            self._normals = np.vstack([np.eye(3), -np.eye(3)])
            self._offsets = 0.5 * np.tile(shape.size, 2)
        elif isinstance(shape, Cylinder):
            angles = np.linspace(0.0, 2.0 * np.pi, _FACES, endpoint=False)
            around = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(_FACES)])
            self._normals = np.vstack([around, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
            self._offsets = np.repeat([shape.radius, 0.5 * shape.length], [_FACES, 2])
        else:
            hull = convex_hull(shape.file, shape.scale)
            self._normals = np.asarray(hull.face_normals, float)
            corners = np.asarray(hull.triangles, float)[:, 0]
            self._offsets = np.einsum("ij,ij->i", self._normals, corners)

    def distances(
        self, T_world_link: FloatArray, starts: FloatArray, ends: FloatArray, within: float
    ) -> FloatArray:
        """Return the distances to segments, shape (k,), in [m]; negative inside.

        For a hull, the distance to the planes of its faces is used. It is exact inside and in front
        of a face, and a lower bound in front of an edge.

        Args:
            starts: Start points, shape (k, 3), in [m].
            ends: End points, shape (k, 3), in [m].
            within: Distance in [m] above which the result may be infinite.
        """
        T = np.linalg.inv(T_world_link @ self._T_link_shape)
        starts, ends = (points @ T[:3, :3].T + T[:3, 3] for points in (starts, ends))
        if self._radius:
            axis = np.broadcast_to(self._end, starts.shape)
            return segment_distances(starts, ends, -axis, axis) - self._radius
        a, b = (points @ self._normals.T - self._offsets for points in (starts, ends))
        distances = np.full(len(a), np.inf)
        near = np.flatnonzero(np.minimum(a, b).max(axis=1) <= within)
        if len(near):
            distances[near] = _lowest_maximum(a[near], b[near])
        return distances


def _lowest_maximum(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the minimum over 0 <= t <= 1 of max((1 - t) a + t b), a convex function of t.

    Args:
        a: Values at t = 0, shape (k, m); the maximum is over m.
        b: Values at t = 1, shape (k, m).

    Returns:
        The minima, shape (k,).
    """
    change = b - a

    def largest(t: FloatArray) -> FloatArray:
        values: FloatArray = np.max(a + t[:, None] * change, axis=1)
        return values

    low, high = np.zeros(len(a)), np.ones(len(a))
    for _ in range(_NARROWINGS):
        left, right = low + (high - low) / 3.0, high - (high - low) / 3.0
        is_left = largest(left) <= largest(right)
        low, high = np.where(is_left, low, left), np.where(is_left, right, high)
    return largest(0.5 * (low + high))


def _pairs_within(
    starts: FloatArray, ends: FloatArray, within: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the indices i < j of all segments at most `within` apart, and of some others.

    Boxes around the segments are compared, in the order of their positions along one axis.
    """
    low = np.minimum(starts, ends) - 0.5 * within
    high = np.maximum(starts, ends) + 0.5 * within
    order = np.argsort(low[:, 0])
    following = np.searchsorted(low[order, 0], high[order, 0], "right")
    counts = following - np.arange(1, len(low) + 1)
    first = np.repeat(np.arange(len(low)), counts)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    i, j = order[first], order[second]
    meet = ((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1)
    return np.minimum(i, j)[meet], np.maximum(i, j)[meet]


def segment_distances(
    p: FloatArray, p_end: FloatArray, r: FloatArray, r_end: FloatArray
) -> FloatArray:
    """Return the distances of pairs of segments, shape (k,), in [m].

    The distance is the minimum of |p + s u - r - t v| for s and t from 0 to 1. It is reached at the
    nearest points of both lines if these are inside of the segments, otherwise at an end point of a
    segment.

    Args:
        p: Start points of the first segments, shape (k, 3), in [m].
        p_end: End points of the first segments.
        r: Start points of the second segments.
        r_end: End points of the second segments.
    """
    u, v, w = p_end - p, r_end - r, p - r
    uu, uv, vv = _dot(u, u), _dot(u, v), _dot(v, v)
    uw, vw = _dot(u, w), _dot(v, w)
    determinant = uu * vv - uv * uv
    crossed = determinant > 0
    divisor = np.where(crossed, determinant, 1.0)
    s, t = (uv * vw - vv * uw) / divisor, (uu * vw - uv * uw) / divisor
    inside = crossed & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    s, t = np.where(inside, s, 0.0), np.where(inside, t, 0.0)
    gap = w + s[:, None] * u - t[:, None] * v
    lines = np.where(inside, np.sqrt(_dot(gap, gap)), np.inf)
    edges = [
        _point_distances(p, r, v),
        _point_distances(p_end, r, v),
        _point_distances(r, p, u),
        _point_distances(r_end, p, u),
    ]
    smallest: FloatArray = np.minimum.reduce([lines, *edges])
    return smallest


def _point_distances(point: FloatArray, start: FloatArray, way: FloatArray) -> FloatArray:
    """Return the distances of points from segments start + t way, 0 <= t <= 1, shape (k,)."""
    length = _dot(way, way)
    t = _dot(point - start, way) / np.where(length > 0, length, 1.0)
    gap = point - start - np.clip(t, 0.0, 1.0)[:, None] * way
    distance: FloatArray = np.sqrt(_dot(gap, gap))
    return distance


def _share_an_end(
    p: FloatArray, p_end: FloatArray, r: FloatArray, r_end: FloatArray
) -> NDArray[np.bool_]:
    """Return flags of the pairs of segments with a common end point, as at shared attachments."""
    pairs = ((p, r), (p, r_end), (p_end, r), (p_end, r_end))
    shared: NDArray[np.bool_] = np.logical_or.reduce(
        [_dot(a - b, a - b) < _SAME**2 for a, b in pairs]
    )
    return shared


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = np.einsum("ij,ij->i", a, b)
    return product
