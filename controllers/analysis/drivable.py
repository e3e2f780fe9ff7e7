"""Coordinates that muscles can drive at a pose, and the missing torque of the other coordinates.

Muscles drive the coordinates S if they can hold them and accelerate each one in both directions.
This requires that the torque G_S is in the interior of {A_S f : low <= f <= high}. It is in the
interior if and only if A_S has full row rank and a force f strictly within its limits produces G_S.
The following linear program checks this:

    max t   s.t.  A_S f = G_S,  low + t w <= f <= high - t w,  w = (high - low) / 2            (1)

If the muscles drive S, t is in (0, 1]. Otherwise t is negative, and the multipliers indicate the
direction in which torque is missing. The other coordinates must be locked or driven by motors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from controllers.arrays import FloatArray

MARGIN = 1e-3
"""Minimum t of eq. (1) for a torque that is treated as interior."""
ACCELERATION = {"rad": 0.3, "m": 0.03}
"""Acceleration that each coordinate must reach in both directions, in [rad/s²] or [m/s²]."""

# The effect of a drive is limited to this multiple of the median. Otherwise one very strong drive
# would make all others appear weak.
_MAX_TORQUE = 1e150  # whose square is finite
_MAX_STRENGTH = 1e3
# Relative to the direction with the largest acceleration. Weaker directions are not drivable.
_RANK_TOLERANCE = 1e-5


Missing = Literal["any muscle", "up", "down", "independent motion"]
"""Reason why a coordinate is not drivable.

    any muscle: No muscle moves the coordinate.
    up, down: No muscle produces enough positive, or negative, torque.
    independent motion: The motion depends on other coordinates, or is too weak.
"""


@dataclass(frozen=True)
class Terms:
    """Equation of motion of a robot at a pose.

    Attributes:
        M: Mass matrix, shape (n, n), regular.
        A: Torques per unit force of the drives, -L' for muscles, shape (n, m), in [m] or [1].
        torque: Torque that the drives must hold, shape (n,), in [N·m] or [N].
        low, high: Force limits of the drives, shape (m,), finite, in [N].
        acceleration: Required acceleration of each coordinate, shape (n,), in [rad/s²] or [m/s²].
    """

    M: FloatArray
    A: FloatArray
    torque: FloatArray
    low: FloatArray
    high: FloatArray
    acceleration: FloatArray


@dataclass(frozen=True)
class DrivableCoordinates:
    """Coordinates that muscles can drive at a pose.

    Attributes:
        coordinates: Indices of the coordinates, in order.
        margin: t of eq. (1) for these coordinates; 0 without coordinates.
        missing: Reason why each other candidate is not drivable, by index.
    """

    coordinates: tuple[int, ...]
    margin: float
    missing: dict[int, Missing] = field(default_factory=dict)


def find_drivable(terms: Terms, candidates: Sequence[int]) -> DrivableCoordinates:
    """Find the coordinates that the drives can hold and accelerate, by a greedy search.

    Args:
        terms: Equation of motion at the pose.
        candidates: Indices of the coordinates to drive. All other coordinates are locked.
    """
    missing: dict[int, Missing] = {}
    rows = _independent_coordinates(terms, list(candidates), missing)
    while rows:
        weakest = _weakest_coordinate(terms, rows)
        if weakest is None:
            break
        k, reason = weakest
        missing[k] = reason
        rows.remove(k)
    for k in reversed(list(missing)):
        extended = sorted([*rows, k])
        if missing[k] != "any muscle" and _weakest_coordinate(terms, extended) is None:
            rows = extended
            del missing[k]
    margin = force_margin(terms, rows)[0] if rows else 0.0
    return DrivableCoordinates(tuple(sorted(rows)), margin, missing)


@np.errstate(over="ignore")  # of muscles with huge moment arms
def force_margin(terms: Terms, rows: Sequence[int]) -> tuple[float, FloatArray, FloatArray]:
    """Solve eq. (1) for the given coordinates.

    Returns:
        t, the multipliers and the forces. t is -inf if A_S is rank deficient or if a coordinate
        does not move a mass. The multipliers are the derivatives of t with respect to the torque of
        each coordinate, relative to the square root of its inertia. The forces are in [N], and NaN
        if the program is infeasible.
    """
    index, m = list(rows), terms.A.shape[1]
    root = np.sqrt(np.diag(terms.M)[index])
    if not (root > 0.0).all():
        return -np.inf, np.zeros(len(index)), np.full(m, np.nan)
    w = np.maximum(0.5 * (terms.high - terms.low), 1e-300)
    A = terms.A[index] / root[:, None] * w  # of (f - low) / w
    A = np.clip(A, -_MAX_TORQUE, _MAX_TORQUE)
    b = (terms.torque[index] - terms.A[index] @ terms.low) / root
    size = max(float(np.abs(A).max(initial=0.0)), 1e-300)
    from scipy.optimize import linprog  # slow to import

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


@np.errstate(over="ignore")  # the ratio overflows for a drive that has almost no effect
def _scaled_torques(terms: Terms, rows: Sequence[int]) -> FloatArray:
    """Return the torques of the full force ranges, relative to the square roots of the inertias."""
    root = np.sqrt(np.diag(terms.M)[list(rows)])
    scaled: FloatArray = terms.A[list(rows)] * (terms.high - terms.low) / root[:, None]
    scaled = np.clip(scaled, -_MAX_TORQUE, _MAX_TORQUE)
    sizes = np.linalg.norm(scaled, axis=0)
    limit = _MAX_STRENGTH * float(np.median(sizes[sizes > 0.0])) if sizes.any() else 1.0
    scaled *= np.minimum(1.0, limit / np.maximum(sizes, 1e-300))
    return scaled


def _independent_coordinates(
    terms: Terms, candidates: list[int], missing: dict[int, Missing]
) -> list[int]:
    """Return the coordinates that the drives move independently, and record the others."""
    if not candidates:
        return []
    scaled = _scaled_torques(terms, candidates)
    from scipy.linalg import qr  # slow to import

    factors: Any = qr(scaled.T, mode="r", pivoting=True)
    order, sizes = factors[1].tolist(), np.abs(np.diag(np.atleast_2d(factors[0])))
    rank = int(np.count_nonzero(sizes > _RANK_TOLERANCE * sizes.max(initial=0.0)))
    moved = np.abs(scaled).max(axis=1) > _RANK_TOLERANCE * max(np.abs(scaled).max(), 1e-300)
    for k in order[rank:]:
        missing[candidates[k]] = "independent motion" if moved[k] else "any muscle"
    return sorted(candidates[k] for k in order[:rank])


def _weakest_coordinate(terms: Terms, rows: list[int]) -> tuple[int, Missing] | None:
    """Return the coordinate with the largest missing torque and the reason, or None."""
    U, sizes, _ = np.linalg.svd(_scaled_torques(terms, rows))
    if len(sizes) < len(rows) or sizes[-1] <= _RANK_TOLERANCE * sizes[0]:
        return rows[int(np.argmax(np.abs(U[:, -1])))], "independent motion"
    t, slopes, _ = force_margin(terms, rows)
    if t > MARGIN:
        ratios = _acceleration_ratios(terms, rows, t)
        worst = int(np.argmin(ratios))
        return None if ratios[worst] >= 1.0 else (rows[worst], "independent motion")
    if not np.isfinite(t):
        return rows[-1], "independent motion"
    worst = int(np.argmax(np.abs(slopes)))
    return rows[worst], "down" if slopes[worst] > 0.0 else "up"


def _acceleration_ratios(terms: Terms, rows: list[int], t: float) -> FloatArray:
    """Return the acceleration that the margin t allows, relative to the required acceleration."""
    w = 0.5 * (terms.high - terms.low)
    inverse = np.linalg.pinv(terms.A[rows] * w)  # (m, S): relative forces for unit torques
    torque = t / np.maximum(np.abs(inverse).max(axis=0), 1e-300)
    needed = np.diag(terms.M)[rows] * terms.acceleration[rows]
    return np.asarray(torque / np.maximum(needed, 1e-300))
