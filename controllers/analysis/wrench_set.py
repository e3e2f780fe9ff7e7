"""Available torques {-L'f : f_min <= f <= f_max} and the margins of desired torques within them.

The set is a zonotope. Every facet is parallel to n - 1 columns of L'. All choices of n - 1 muscles
therefore yield all facet normals c, and the support function is
h(c) = sum_i max(-c'L_i f_min_i, -c'L_i f_max_i). This is the hyperplane shifting method of
Bouchard, Gosselin, Moore, "On the ability of a cable-driven robot to generate a prescribed set of
wrenches", J. Mechanisms and Robotics 2 (2010), and Gouttefarde, Krut, "Characterization of parallel
manipulator available wrench set facets", Advances in Robot Kinematics (2010).

`poses.gather` defines the arguments L (muscle Jacobians), tau (desired torques), f_min and f_max
(force limits). They describe one pose or a stack of poses. All functions raise InputError if a size
is wrong, a number is out of range, or there are too many facets.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from addin_sdfusion.robot import InputError
from controllers.arrays import BoolArray, FloatArray
from controllers.force_distribution.poses import Poses, gather

MAX_FACETS = 20_000
"""Maximum number of choices of n - 1 muscles that are evaluated."""

_RANK_TOLERANCE = 1e-9  # values are zero below this fraction of the largest value
_MAX_CHUNK = 2_000_000  # numbers in memory per chunk of poses


class _Facets(NamedTuple):
    """Candidate facets of the sets at some poses. They include every facet.

    Attributes:
        rows: Slice of the poses.
        normals: Unit vectors c, shape (P, 2 K, n); zero if the n - 1 muscles are dependent.
        pull: -c'L_i, torque of 1 N of each muscle along the normal, shape (P, 2 K, m).
    """

    rows: slice
    normals: FloatArray
    pull: FloatArray

    @property
    def real(self) -> BoolArray:
        """Whether each candidate has a normal, shape (P, 2 K)."""
        return np.asarray(np.any(self.normals != 0.0, axis=2))


def too_many_facets(m: int, n: int) -> bool:
    """Return whether m muscles for n coordinates have too many candidate facets."""
    return n > 0 and comb(m, n - 1) > MAX_FACETS


def full_rank(L: FloatArray) -> BoolArray:
    """Return whether L, shape (P, m, n), has full column rank at each pose, shape (P,)."""
    if L.shape[1] < L.shape[2]:
        return np.zeros(len(L), dtype=bool)
    s = np.linalg.svd(L, compute_uv=False)
    return np.asarray(s[:, -1] > _RANK_TOLERANCE * s[:, 0])


def capacity_margin(
    L: ArrayLike,
    tau: ArrayLike,
    f_min: ArrayLike,
    f_max: ArrayLike,
    *,
    half_widths: ArrayLike | None = None,
) -> FloatArray:
    """Return the distance of desired torques from the nearest facet, shape (...).

    The margin is positive inside the set, and is the minimum over the corners of the desired set.
    It is not negative if and only if every desired torque is available. It corresponds to
    `CapacityMarginMetric` of CASPR, after Cruz Ruiz, Caro, Cardou, Guay, "ARACHNIS", Cable-Driven
    Parallel Robots (2015). For a robot with both revolute and prismatic coordinates the distance
    has mixed units; use `torque_margins` instead.

    With half_widths W, shape (..., n, k), the desired torques are tau + W s with |s_j| <= 1. They
    form a box if W is diagonal.

    Returns:
        Margin, in [N·m] or [N]. It is NaN if the muscles do not act on all coordinates
        independently, since the set is then flat.
    """
    poses = gather(L, tau, f_min, f_max)
    W = _generators(half_widths, poses)
    margin = np.full(len(poses.L), np.nan)
    for facets in _facets(poses):
        slack = _slack(poses, facets)
        if W is not None:
            slack -= np.abs(np.einsum("pkn,pnw->pkw", facets.normals, W[facets.rows])).sum(axis=2)
        margin[facets.rows] = np.where(facets.real, slack, np.inf).min(axis=1)
    flat = ~full_rank(poses.L)
    return np.where(flat, np.nan, margin).reshape(poses.stack)


def torque_margins(
    L: ArrayLike, tau: ArrayLike, f_min: ArrayLike, f_max: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return the largest additional torque of each single coordinate, down and up.

    Returns:
        Two arrays of shape (..., n), in [N·m] or [N]. They are NaN if tau is not available, and if
        the muscles do not act on all coordinates independently.
    """
    poses = gather(L, tau, f_min, f_max)
    down, up = (np.full(poses.tau.shape, np.nan) for _ in range(2))
    for facets in _facets(poses):
        slack = np.where(facets.real, _slack(poses, facets), np.inf)[:, :, None]
        tau_size = np.abs(poses.tau[facets.rows]).max(axis=1) + 1.0
        outside = np.any(slack[:, :, 0] < -_RANK_TOLERANCE * tau_size[:, None], axis=1)
        for margins, sign in ((down, -1.0), (up, 1.0)):
            speed = sign * facets.normals
            crossed = speed > _RANK_TOLERANCE
            distances = np.where(crossed, slack / np.where(crossed, speed, 1.0), np.inf)
            margins[facets.rows] = np.where(outside[:, None], np.nan, distances.min(axis=1))
    flat = ~full_rank(poses.L)[:, None]
    shape = (*poses.stack, poses.n)
    return np.where(flat, np.nan, down).reshape(shape), np.where(flat, np.nan, up).reshape(shape)


def has_wrench_closure(L: ArrayLike) -> BoolArray:
    """Return whether muscles without upper force limits can produce every torque, shape (...).

    This requires that L has full rank and that some muscle pulls to each side of the hyperplane
    spanned by every choice of n - 1 muscles. CASPR calls this the combinatoric positive span.
    Gouttefarde, Gosselin, "Analysis of the wrench-closure workspace of planar parallel cable-driven
    mechanisms", IEEE Trans. Robotics 22 (2006).
    """
    shape = np.shape(L)
    if len(shape) >= 2 and 0 in shape[-2:]:  # True without coordinates, else False
        return np.full(shape[:-2], shape[-1] == 0)
    poses = gather(L, np.zeros(shape[-1:]), 0.0, np.inf)
    closed = full_rank(poses.L)
    for facets in _facets(poses):
        pulled = np.any(facets.pull > 0.0, axis=2)
        closed[facets.rows] &= np.all(pulled | ~facets.real, axis=1)
    return closed.reshape(poses.stack)


def _generators(half_widths: ArrayLike | None, poses: Poses) -> FloatArray | None:
    if half_widths is None:
        return None
    W = np.asarray(half_widths, dtype=np.float64)
    if W.ndim < 2 or W.shape[-2] != poses.n or not np.isfinite(W).all():
        raise InputError(
            f"half_widths must be finite with shape (..., {poses.n}, k), not {W.shape}"
        )
    try:
        per_pose = np.broadcast_to(W, (*poses.stack, *W.shape[-2:]))
    except ValueError:
        raise InputError(f"half_widths {W.shape} do not match poses {poses.stack}") from None
    return np.asarray(per_pose.reshape(-1, *W.shape[-2:]))


def _slack(poses: Poses, facets: _Facets) -> FloatArray:
    """Return h(c) - c'tau of every candidate, shape (P, 2 K), in [N·m] or [N]."""
    low, high = poses.f_min[facets.rows, None], poses.f_max[facets.rows, None]
    pull = facets.pull
    with np.errstate(invalid="ignore"):
        support = np.where(pull > 0, pull * high, np.where(pull < 0, pull * low, 0.0))
    desired = np.einsum("pkn,pn->pk", facets.normals, poses.tau[facets.rows])
    slack: FloatArray = support.sum(axis=2) - desired
    return slack


def _facets(poses: Poses) -> Iterator[_Facets]:
    """Yield candidate facets in chunks of poses; nothing if there are too few muscles."""
    m, n = poses.m, poses.n
    if m < n - 1:
        return
    if too_many_facets(m, n):
        raise InputError(
            f"{m} muscles for {n} coordinates have up to {2 * comb(m, n - 1)} facets; the maximum "
            f"is {2 * MAX_FACETS}"
        )
    choices = np.array(list(combinations(range(m), n - 1)), dtype=int)
    step = max(1, _MAX_CHUNK // (len(choices) * n * max(m, n)))
    for begin in range(0, len(poses.L), step):
        rows = slice(begin, begin + step)
        normals = _normals(poses.L[rows], choices)
        pull = -np.einsum("pkn,pmn->pkm", normals, poses.L[rows])
        size = np.abs(poses.L[rows]).max(axis=(1, 2), initial=0.0)
        pull[np.abs(pull) <= _RANK_TOLERANCE * size[:, None, None]] = 0.0
        yield _Facets(
            rows,
            np.concatenate([normals, -normals], axis=1),
            np.concatenate([pull, -pull], axis=1),
        )


def _normals(L: FloatArray, choices: NDArray[np.int_]) -> FloatArray:
    """Return unit normals of all choices of n - 1 rows of L; zero if the rows are dependent."""
    n = L.shape[2]
    spans = L[:, choices]  # (P, K, n - 1, n)
    others = [np.delete(np.arange(n), j) for j in range(n)]
    normals = np.stack(
        [(-1.0) ** j * np.linalg.det(spans[..., others[j]]) for j in range(n)], axis=2
    )
    length = np.linalg.norm(normals, axis=2, keepdims=True)
    volume = np.linalg.norm(spans, axis=3).prod(axis=2)[..., None]
    real = length > _RANK_TOLERANCE * volume
    return np.asarray(np.where(real, normals / np.where(real, length, 1.0), 0.0))
