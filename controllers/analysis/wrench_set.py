"""Available torques {-L'f : f_min <= f <= f_max} and the margins of desired torques within them.

The set is a zonotope. Every facet is parallel to n - 1 columns of L', so its normals are found from
all choices of n - 1 muscles, for all poses at once, and its support is
h(c) = sum_i max(-c'L_i f_min_i, -c'L_i f_max_i): hyperplane shifting, as in Bouchard, Gosselin,
Moore, "On the ability of a cable-driven robot to generate a prescribed set of wrenches", J.
Mechanisms and Robotics 2 (2010), and Gouttefarde, Krut, "Characterization of parallel manipulator
available wrench set facets", Advances in Robot Kinematics (2010).

Muscle Jacobians L, desired torques tau and bounds f_min, f_max are those of `poses.gather`, for one
pose or a stack of poses; InputError if a size or a number is wrong, or there are too many facets.
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
"""Most choices of n - 1 muscles that are gone through."""

_RANK = 1e-9  # what is below this part of the largest is zero
_CHUNK = 2_000_000  # numbers held at once


class _Facets(NamedTuple):
    """Candidates for facets of some poses: every facet of the set is among them.

    Attributes:
        rows: Which poses.
        normals: Unit vectors, shape (P, 2 K, n); zero if n - 1 muscles span less.
        pull: -c'L_i, what 1 N of each muscle does along the normal, shape (P, 2 K, m).
    """

    rows: slice
    normals: FloatArray
    pull: FloatArray

    @property
    def real(self) -> BoolArray:
        """Which candidates have a normal, shape (P, 2 K)."""
        return np.asarray(np.any(self.normals != 0.0, axis=2))


def too_many_facets(m: int, n: int) -> bool:
    """Return whether m muscles for n coordinates make more facets than are gone through."""
    return n > 0 and comb(m, n - 1) > MAX_FACETS


def full_rank(L: FloatArray) -> BoolArray:
    """Whether the muscles, L of shape (P, m, n), act on all coordinates independently; (P,)."""
    if L.shape[1] < L.shape[2]:
        return np.zeros(len(L), dtype=bool)
    s = np.linalg.svd(L, compute_uv=False)
    return np.asarray(s[:, -1] > _RANK * s[:, 0])


def capacity_margin(
    L: ArrayLike,
    tau: ArrayLike,
    f_min: ArrayLike,
    f_max: ArrayLike,
    *,
    half_widths: ArrayLike | None = None,
) -> FloatArray:
    """Distance of desired torques from the nearest facet, positive within; shape (...).

    CASPR's `CapacityMarginMetric`, after Cruz Ruiz, Caro, Cardou, Guay, "ARACHNIS", Cable-Driven
    Parallel Robots (2015): the smallest over the corners of the desired set. It is not negative
    exactly where every desired torque is possible. Revolute and prismatic coordinates together make
    it a distance of mixed units; `torque_margins` does not mix them.

    With half_widths W, shape (..., n, k), the desired torques are tau + W s with |s_j| <= 1: a box
    where W is diagonal.

    Returns:
        In [N·m] or [N]; NaN if the muscles do not act on all coordinates independently, for
        there the set is flat.
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
    """How much more torque each coordinate can have, alone, down and up; both of shape (..., n).

    Returns:
        In [N·m] or [N]; NaN if tau itself is out of reach, and where the muscles do not act on
        all coordinates independently.
    """
    poses = gather(L, tau, f_min, f_max)
    down, up = (np.full(poses.tau.shape, np.nan) for _ in range(2))
    for facets in _facets(poses):
        slack = np.where(facets.real, _slack(poses, facets), np.inf)[:, :, None]
        tau_size = np.abs(poses.tau[facets.rows]).max(axis=1) + 1.0
        outside = np.any(slack[:, :, 0] < -_RANK * tau_size[:, None], axis=1)
        for margins, sign in ((down, -1.0), (up, 1.0)):
            speed = sign * facets.normals
            crossed = speed > _RANK
            ways = np.where(crossed, slack / np.where(crossed, speed, 1.0), np.inf)
            margins[facets.rows] = np.where(outside[:, None], np.nan, ways.min(axis=1))
    flat = ~full_rank(poses.L)[:, None]
    shape = (*poses.stack, poses.n)
    return np.where(flat, np.nan, down).reshape(shape), np.where(flat, np.nan, up).reshape(shape)


def has_wrench_closure(L: ArrayLike) -> BoolArray:
    """Return whether unlimited muscles could make any torque, shape (...).

    It is so if and only if L has full rank and on both sides of every choice of n - 1 muscles there
    is a muscle that pulls there: CASPR's combinatoric positive span; Gouttefarde, Gosselin,
    "Analysis of the wrench-closure workspace of planar parallel cable-driven mechanisms", IEEE
    Trans. Robotics 22 (2006).
    """
    shape = np.shape(L)
    if len(shape) >= 2 and 0 in shape[-2:]:  # no torque is asked for, or none is made
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
        whole = np.broadcast_to(W, (*poses.stack, *W.shape[-2:]))
    except ValueError:
        raise InputError(f"half_widths {W.shape} do not fit poses {poses.stack}") from None
    return np.asarray(whole.reshape(-1, *W.shape[-2:]))


def _slack(poses: Poses, facets: _Facets) -> FloatArray:
    """h(c) - c'tau of every candidate, shape (P, 2 K), in [N·m] or [N]."""
    low, high = poses.f_min[facets.rows, None], poses.f_max[facets.rows, None]
    pull = facets.pull
    with np.errstate(invalid="ignore"):
        made = np.where(pull > 0, pull * high, np.where(pull < 0, pull * low, 0.0))
    desired = np.einsum("pkn,pn->pk", facets.normals, poses.tau[facets.rows])
    slack: FloatArray = made.sum(axis=2) - desired
    return slack


def _facets(poses: Poses) -> Iterator[_Facets]:
    """The candidates for facets, some poses at a time; none if the muscles are too few."""
    m, n = poses.m, poses.n
    if m < n - 1:
        return
    if too_many_facets(m, n):
        raise InputError(
            f"{m} muscles for {n} coordinates make up to {2 * comb(m, n - 1)} facets, too many"
        )
    choices = np.array(list(combinations(range(m), n - 1)), dtype=int)
    step = max(1, _CHUNK // (len(choices) * n * max(m, n)))
    for begin in range(0, len(poses.L), step):
        rows = slice(begin, begin + step)
        normals = _normals(poses.L[rows], choices)
        pull = -np.einsum("pkn,pmn->pkm", normals, poses.L[rows])
        size = np.abs(poses.L[rows]).max(axis=(1, 2), initial=0.0)
        pull[np.abs(pull) <= _RANK * size[:, None, None]] = 0.0
        yield _Facets(
            rows,
            np.concatenate([normals, -normals], axis=1),
            np.concatenate([pull, -pull], axis=1),
        )


def _normals(L: FloatArray, choices: NDArray[np.int_]) -> FloatArray:
    """Unit normals of all choices of n - 1 rows of L, by cofactors; zero if they span less."""
    n = L.shape[2]
    spans = L[:, choices]  # (P, K, n - 1, n)
    others = [np.delete(np.arange(n), j) for j in range(n)]
    normals = np.stack(
        [(-1.0) ** j * np.linalg.det(spans[..., others[j]]) for j in range(n)], axis=2
    )
    length = np.linalg.norm(normals, axis=2, keepdims=True)
    volume = np.linalg.norm(spans, axis=3).prod(axis=2)[..., None]
    real = length > _RANK * volume
    return np.asarray(np.where(real, normals / np.where(real, length, 1.0), 0.0))
