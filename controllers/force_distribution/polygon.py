"""Feasible polygon: all feasible forces of a robot with two more muscles than coordinates.

The forces are f = f_0 + N lam. Here, f_0 = A⁺ tau are the smallest forces, A = -L', and N is an
orthonormal basis of the null space of A, shape (m, 2). The 2m force limits restrict lam to a convex
polygon. Each limit is a line in the plane, and the other limits reduce this line to an interval, an
edge of the polygon. Area and centroid are integrals over the edges. The minimum sum is at an end of
an edge, and the minimum norm is at the point nearest to the origin.
Gouttefarde, Lamaury, Reichert, Bruckmann, "A versatile tension distribution algorithm for n-DOF
parallel robots driven by n + 2 cables", IEEE Trans. Robotics 31 (2015); CASPR's
`IDSolverFeasiblePolygon`. This implementation computes all edges at the same time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from controllers.arrays import BoolArray, FloatArray

from .poses import Poses, distribution, gather, require_finite_bounds

_RANK_TOLERANCE = 1e-10  # singular values are zero below this fraction of the largest
_PARALLEL = 1e-10  # largest sine of the angle between parallel lines
_ZERO_LENGTH = 1e-9  # lengths are zero below this value, relative to the largest force limit


@dataclass(frozen=True, eq=False)
class ForcePolygon:
    """Feasible polygons of P poses: f = f_0 + N lam.

    Attributes:
        f_0: Smallest forces without limits, shape (P, m), in [N].
        N: Orthonormal basis of the null space, shape (P, m, 2).
        starts, ends: Ends of the edge on the line of every limit, lower limits first, shape
            (P, 2m, 2), in [N], counter-clockwise; NaN if this edge does not exist.
    """

    poses: Poses
    f_0: FloatArray
    N: FloatArray
    starts: FloatArray
    ends: FloatArray

    @property
    def area(self) -> FloatArray:
        """Area of the polygon, shape (P,), in [N²]; 0 if it is empty."""
        area: FloatArray = 0.5 * np.nansum(_cross(self.starts, self.ends), axis=1)
        return area

    def vertices(self, pose: int = 0) -> FloatArray:
        """Return forces at the corners, counter-clockwise, shape (corners, m), in [N].

        Args:
            pose: Index of the pose in the flattened stack.
        """
        lam = self.starts[pose]
        lam = lam[np.isfinite(lam).all(axis=1)]
        if not len(lam):
            return np.empty((0, self.poses.m))
        around = lam - lam.mean(axis=0)
        lam = lam[np.argsort(np.arctan2(around[:, 1], around[:, 0]))]
        size = _ZERO_LENGTH * (1.0 + np.abs(self.poses.f_max[pose]).max())
        step = np.linalg.norm(lam - np.roll(lam, 1, axis=0), axis=1)
        lam = lam[step > size] if (step > size).any() else lam[:1]
        return np.asarray(self.f_0[pose] + lam @ self.N[pose].T)

    def forces(self, lam: FloatArray) -> FloatArray:
        """Return the forces f_0 + N lam, shape (P, m), in [N].

        Args:
            lam: Points in the plane of the polygon, shape (P, 2), in [N].
        """
        return np.asarray(self.f_0 + np.einsum("pmk,pk->pm", self.N, lam))


def feasible_polygon(
    L: ArrayLike, tau: ArrayLike, f_min: ArrayLike, f_max: ArrayLike
) -> ForcePolygon:
    """Compute the feasible polygon of every pose.

    Args:
        L: Muscle Jacobians, shape (..., m, n) with m = n + 2, in [m/rad] or [m/m].
        tau: Desired torques, shape (..., n), in [N·m] or [N].
        f_min: Lower limits, a number, shape (m,) or (..., m), in [N].
        f_max: Finite upper limits, a number, shape (m,) or (..., m), in [N].

    Raises:
        InputError: A size is wrong, a number is out of range, a muscle has no upper limit, or the
            number of muscles is not the number of coordinates plus two.
    """
    return _polygon(gather(L, tau, f_min, f_max))


def _polygon(poses: Poses) -> ForcePolygon:
    if poses.m - poses.n != 2:
        raise InputError(
            f"the feasible polygon requires two more muscles than coordinates, not {poses.m} "
            f"muscles for {poses.n} coordinates; use 'least_squares'"
        )
    require_finite_bounds(poses, "polygon")
    U, s, Vt = np.linalg.svd(poses.A)
    full: BoolArray = s[:, -1] > _RANK_TOLERANCE * s[:, 0]
    safe = np.where(full[:, None], s, 1.0)
    f_0 = np.einsum("pkm,pk->pm", Vt[:, : poses.n], np.einsum("pnk,pn->pk", U, poses.tau) / safe)
    N = np.swapaxes(Vt[:, poses.n :], 1, 2)
    starts, ends = _edges(poses, f_0, N)
    starts[~full], ends[~full] = np.nan, np.nan  # the null space has more than two dimensions
    return ForcePolygon(poses, f_0, N, starts, ends)


@distribution()
def polygon_1_norm(poses: Poses) -> FloatArray:
    """Return the forces with the minimum sum, at a corner of the polygon."""
    polygon = _polygon(poses)
    corners = np.concatenate([polygon.starts, polygon.ends], axis=1)
    sums = np.einsum("pmk,pck->pc", polygon.N, corners)
    lam = _minimum_point(np.where(np.isnan(sums), np.inf, sums), corners)
    return polygon.forces(lam)


@distribution()
def polygon_2_norm(poses: Poses) -> FloatArray:
    """Return the forces of minimum norm, at the point of the polygon nearest to the origin."""
    polygon = _polygon(poses)
    edges = polygon.ends - polygon.starts
    square = np.sum(edges**2, axis=2)
    along = -np.sum(polygon.starts * edges, axis=2)
    s = np.clip(along / np.where(square > 0, square, 1.0), 0.0, 1.0)
    points = polygon.starts + s[:, :, None] * edges
    norms = np.sum(points**2, axis=2)
    lam = _minimum_point(np.where(np.isnan(norms), np.inf, norms), points)
    inside = np.all((polygon.f_0 >= poses.f_min) & (polygon.f_0 <= poses.f_max), axis=1)
    lam = np.where(inside[:, None] & np.isfinite(lam), 0.0, lam)
    return polygon.forces(lam)


@distribution()
def polygon_centroid(poses: Poses) -> FloatArray:
    """Return the centroid of the polygon, continuous along a motion and far from all limits."""
    polygon = _polygon(poses)
    edge = np.all(np.isfinite(polygon.starts), axis=2)
    count = np.maximum(edge.sum(axis=1), 1)[:, None]
    middle = np.nansum(0.5 * (polygon.starts + polygon.ends), axis=1) / count
    a, b = polygon.starts - middle[:, None], polygon.ends - middle[:, None]  # avoids cancellation
    cross = _cross(a, b)
    area = 0.5 * np.nansum(cross, axis=1)
    size = np.nanmax(np.where(edge, np.linalg.norm(a, axis=2), 0.0), axis=1, initial=0.0)
    thin = area <= _ZERO_LENGTH * size**2
    moment = np.nansum((a + b) * cross[:, :, None], axis=1) / 6.0
    lam = middle + np.where(thin[:, None], 0.0, moment / np.where(thin, 1.0, area)[:, None])
    lam = np.where(np.any(edge, axis=1)[:, None], lam, np.nan)
    return polygon.forces(lam)


def _edges(poses: Poses, f_0: FloatArray, N: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return start and end of the edge on the line of every limit, shape (P, 2m, 2), or NaN."""
    length = np.linalg.norm(N, axis=2)
    moves = length > _RANK_TOLERANCE  # forces that depend on lam
    unit = np.where(moves, length, 1.0)
    normals = np.concatenate([N, -N], axis=1) / np.tile(unit, 2)[:, :, None]  # inwards
    offsets = np.concatenate([poses.f_min - f_0, f_0 - poses.f_max], axis=1) / np.tile(unit, 2)
    real = np.tile(moves, 2)
    size = _ZERO_LENGTH * (1.0 + np.abs(poses.f_max).max(axis=1))
    stuck_outside = (~real & (offsets > size[:, None])).any(axis=1)
    points = normals * offsets[:, :, None]
    directions = np.stack([normals[:, :, 1], -normals[:, :, 0]], axis=2)
    lower, upper = _intervals(points, directions, normals, offsets, real, size)
    edge = (lower <= upper + size[:, None]) & real & ~stuck_outside[:, None]
    lower, upper = np.where(edge, lower, np.nan), np.where(edge, np.maximum(lower, upper), np.nan)
    return points + lower[:, :, None] * directions, points + upper[:, :, None] * directions


def _intervals(
    points: FloatArray,
    directions: FloatArray,
    normals: FloatArray,
    offsets: FloatArray,
    real: BoolArray,
    size: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the interval of t in point + t direction that the other limits allow on every line.

    The half-plane j is normal_j · lam >= offset_j. If lines coincide, only the first one has an
    edge.
    """
    slope = np.einsum("pkd,pjd->pkj", directions, normals)
    missing = offsets[:, None, :] - np.einsum("pkd,pjd->pkj", points, normals)
    along = np.einsum("pkd,pjd->pkj", normals, normals) > 0
    others = real[:, None, :] & ~np.eye(real.shape[1], dtype=bool)
    parallel = np.abs(slope) <= _PARALLEL
    near = size[:, None, None]
    earlier = np.tri(real.shape[1], k=-1, dtype=bool)
    duplicate = along & earlier & (np.abs(missing) <= near)
    closed = (others & parallel & ((missing > near) | duplicate)).any(axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = missing / slope
    lower = np.where(others & (slope > _PARALLEL), t, -np.inf).max(axis=2)
    upper = np.where(others & (slope < -_PARALLEL), t, np.inf).min(axis=2)
    return np.where(closed, np.inf, lower), np.where(closed, -np.inf, upper)


def _minimum_point(values: FloatArray, points: FloatArray) -> FloatArray:
    """Return the point of the minimum value, shape (P, 2); NaN if all values are infinite."""
    best = values.argmin(axis=1)
    rows = np.arange(len(values))
    return np.where(np.isfinite(values[rows, best])[:, None], points[rows, best], np.nan)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
