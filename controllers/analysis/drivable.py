"""Coordinates that muscles can drive at a pose, and what is missing for the others.

Muscles drive the coordinates S if they can hold them and give each some acceleration either way:
the torque G_S is inside of {A_S f : low <= f <= high}. That is so exactly if A_S has full row rank
and some f strictly within its bounds makes G_S, for the image of the inside is the inside of the
image. One linear programme answers it,

    max t   s.t.  A_S f = G_S,  low + t w <= f <= high - t w,  w = (high - low) / 2,           (1)

with t in (0, 1] if they do, and t < 0 if they do not; its multipliers name the direction that
is missing. The other coordinates must be locked, or driven by something else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from scipy.linalg import qr
from scipy.optimize import linprog

from controllers.arrays import FloatArray

MARGIN = 1e-3
"""Least t of eq. (1) that counts as inside."""
ACCELERATION = {"rad": 0.3, "m": 0.03}
"""What each coordinate must be able to do either way, in [rad/s²] or [m/s²]."""

_STRONGEST = 1e3  # times the median of the drives: more does not make the others weak
_RANK = 1e-5  # a direction that muscles accelerate by less than this part of the best is none


Lack = Literal["any muscle", "up", "down", "one of its own"]
"""What a coordinate lacks: a muscle that moves it at all; one that moves it up, or down; a motion
that is independent of the others', or strong enough to matter."""


@dataclass(frozen=True)
class Terms:
    """The forces of a robot at a pose.

    Attributes:
        M: Mass matrix, shape (n, n), regular.
        A: Torques of the drives, -L' for muscles, shape (n, m), in [m] or [1].
        torque: What the drives must hold, shape (n,), in [N·m] or [N].
        low, high: Bounds of the drives, shape (m,), finite, in [N].
        acceleration: What each coordinate must be able to do, shape (n,), in [rad/s²] or [m/s²].
    """

    M: FloatArray
    A: FloatArray
    torque: FloatArray
    low: FloatArray
    high: FloatArray
    acceleration: FloatArray


@dataclass(frozen=True)
class Drivable:
    """What muscles can drive at a pose.

    Attributes:
        coordinates: Indices of the coordinates, in order.
        margin: t of eq. (1) for these; 0 if there are none.
        missing: For every other coordinate that was asked for, what it lacks.
    """

    coordinates: tuple[int, ...]
    margin: float
    missing: dict[int, Lack] = field(default_factory=dict)


def drivable(terms: Terms, among: Sequence[int]) -> Drivable:
    """The coordinates that the drives can hold and accelerate, as many as a greedy search finds.

    Args:
        terms: The forces at the pose.
        among: Indices of the coordinates that are to be driven; others are locked.
    """
    missing: dict[int, Lack] = {}
    left = _independent(terms, list(among), missing)
    while left:
        found = _weakest(terms, left)
        if found is None:
            break
        k, lack = found
        missing[k] = lack
        left.remove(k)
    for k in reversed(list(missing)):
        tried = sorted([*left, k])
        if missing[k] != "any muscle" and _weakest(terms, tried) is None:
            left = tried
            del missing[k]
    margin = force_margin(terms, left)[0] if left else 0.0
    return Drivable(tuple(sorted(left)), margin, missing)


def force_margin(terms: Terms, rows: Sequence[int]) -> tuple[float, FloatArray, FloatArray]:
    """T of eq. (1) for some coordinates, its multipliers and forces.

    It is -inf if A_S lacks rank, or one of them moves no mass.

    Returns:
        t; how it grows with the torque of each coordinate, relative to the root of its inertia;
        the forces, in [N], NaN if there are none.
    """
    index, m = list(rows), terms.A.shape[1]
    root = np.sqrt(np.diag(terms.M)[index])
    if not (root > 0.0).all():
        return -np.inf, np.zeros(len(index)), np.full(m, np.nan)
    w = np.maximum(0.5 * (terms.high - terms.low), 1e-300)
    A = terms.A[index] / root[:, None] * w  # of (f - low) / w
    b = (terms.torque[index] - terms.A[index] @ terms.low) / root
    size = max(float(np.abs(A).max(initial=0.0)), 1e-300)
    answer = linprog(
        np.append(np.zeros(m), -1.0),
        A_ub=np.vstack([np.c_[-np.eye(m), np.ones(m)], np.c_[np.eye(m), np.ones(m)]]),
        b_ub=np.append(np.zeros(m), np.full(m, 2.0)),
        A_eq=np.c_[A, np.zeros(len(index))] / size,
        b_eq=b / size,
        bounds=[(None, None)] * m + [(None, 1.0)],
    )
    if answer.status != 0:
        return -np.inf, np.zeros(len(index)), np.full(m, np.nan)
    slopes = -np.asarray(answer.eqlin.marginals)
    x = np.asarray(answer.x)
    return float(x[m]), slopes, terms.low + w * x[:m]


@np.errstate(over="ignore")  # of a drive that hardly pulls
def _scaled(terms: Terms, rows: Sequence[int]) -> FloatArray:
    """What the ranges of the drives can do to some coordinates, over the roots of inertias."""
    root = np.sqrt(np.diag(terms.M)[list(rows)])
    scaled: FloatArray = terms.A[list(rows)] * (terms.high - terms.low) / root[:, None]
    sizes = np.linalg.norm(scaled, axis=0)
    most = _STRONGEST * float(np.median(sizes[sizes > 0.0])) if sizes.any() else 1.0
    scaled *= np.minimum(1.0, most / np.maximum(sizes, 1e-300))
    return scaled


def _independent(terms: Terms, among: list[int], missing: dict[int, Lack]) -> list[int]:
    """Return the coordinates that the drives move independently, the strongest first."""
    if not among:
        return []
    scaled = _scaled(terms, among)
    factors: Any = qr(scaled.T, mode="r", pivoting=True)
    order, sizes = factors[1].tolist(), np.abs(np.diag(np.atleast_2d(factors[0])))
    rank = int(np.count_nonzero(sizes > _RANK * sizes.max(initial=0.0)))
    moved = np.abs(scaled).max(axis=1) > _RANK * max(np.abs(scaled).max(), 1e-300)
    for k in order[rank:]:
        missing[among[k]] = "one of its own" if moved[k] else "any muscle"
    return sorted(among[k] for k in order[:rank])


def _weakest(terms: Terms, rows: list[int]) -> tuple[int, Lack] | None:
    """The coordinate whose torque is missing most, and what it lacks; None if all are driven."""
    U, sizes, _ = np.linalg.svd(_scaled(terms, rows))
    if len(sizes) < len(rows) or sizes[-1] <= _RANK * sizes[0]:
        return rows[int(np.argmax(np.abs(U[:, -1])))], "one of its own"
    t, slopes, _ = force_margin(terms, rows)
    if t > MARGIN:
        reach = _reach(terms, rows, t)
        worst = int(np.argmin(reach))
        return None if reach[worst] >= 1.0 else (rows[worst], "one of its own")
    if not np.isfinite(t):
        return rows[-1], "one of its own"
    worst = int(np.argmax(np.abs(slopes)))
    return rows[worst], "down" if slopes[worst] > 0.0 else "up"


def _reach(terms: Terms, rows: list[int], t: float) -> FloatArray:
    """What the forces that are t within their bounds add to each coordinate, over what it needs."""
    w = 0.5 * (terms.high - terms.low)
    inverse = np.linalg.pinv(terms.A[rows] * w)  # (m, S): relative forces for unit torques
    torque = t / np.maximum(np.abs(inverse).max(axis=0), 1e-300)
    needed = np.diag(terms.M)[rows] * terms.acceleration[rows]
    return np.asarray(torque / np.maximum(needed, 1e-300))
