"""Stacked poses, the checked forces of a distribution over them, and a status for each pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from addin_sdfusion.robot import InputError
from controllers.arrays import BoolArray, FloatArray

from .feasibility import is_infeasible

SOLVED = "solved"
INFEASIBLE = "infeasible"
NO_ANSWER = "no answer"

# Largest torque error of an accepted answer, relative to the terms that are added up, and largest
# violation of a bound that counts as rounding, relative to 1 N or the bound.
_ACCEPTED = 1e-8
_ROUNDING = 1e-7
_MIN_ROW = 1e-6  # a row counts as large as this part of the largest: below is rounding


class Poses(NamedTuple):
    """P poses: A f = tau with A = -L', f_min <= f <= f_max.

    Attributes:
        L: Muscle Jacobians, shape (P, m, n), in [m/rad] or [m/m].
        A: -L', shape (P, n, m).
        tau: Desired torques, shape (P, n), in [N·m] or [N].
        f_min, f_max: Bounds, shape (P, m), in [N].
        stack: Shape of the stack that the poses came in.
    """

    L: FloatArray
    A: FloatArray
    tau: FloatArray
    f_min: FloatArray
    f_max: FloatArray
    stack: tuple[int, ...]

    @property
    def m(self) -> int:
        """Number of muscles."""
        return int(self.L.shape[1])

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return int(self.L.shape[2])

    @property
    def middle(self) -> FloatArray:
        """The middle between the bounds, shape (P, m), in [N]."""
        return 0.5 * (self.f_min + self.f_max)

    def only(self, chosen: BoolArray) -> Poses:
        """Some of the poses, in a flat stack."""
        L, A, tau, f_min, f_max, _ = self
        stack = (int(chosen.sum()),)
        return Poses(L[chosen], A[chosen], tau[chosen], f_min[chosen], f_max[chosen], stack)


@dataclass(frozen=True, eq=False)
class DistributedForces:
    """Muscle forces for one pose or a stack of them.

    Attributes:
        method: Name of the distribution.
        forces: f, shape (..., m), in [N]; within the bounds, NaN if there is no answer.
        status: Shape (...): `solved`; `infeasible`, no forces within the bounds make the torque;
            or `no answer`, this method found none but there are some.
        torque_error: Largest |tau + L'f| of a coordinate, shape (...), in [N·m] or [N].
    """

    method: str
    forces: FloatArray
    status: NDArray[np.str_]
    torque_error: FloatArray

    @property
    def solved(self) -> BoolArray:
        """Which poses are solved, shape (...)."""
        return np.asarray(self.status == SOLVED)


def gather(L: ArrayLike, tau: ArrayLike, f_min: ArrayLike, f_max: ArrayLike) -> Poses:
    """Return the poses of any stack, flat and checked.

    Args:
        L: Muscle Jacobians, shape (..., m, n), in [m/rad] or [m/m].
        tau: Desired torques, shape (..., n), in [N·m] or [N].
        f_min: Lower bounds, a number, shape (m,) or (..., m), in [N].
        f_max: Upper bounds, likewise; may be infinite.

    Raises:
        InputError: A size or a number is wrong.
    """
    L_, tau_ = _numbers("L", L), _numbers("tau", tau)
    if L_.ndim < 2 or 0 in L_.shape[-2:] or tau_.ndim < 1 or tau_.shape[-1] != L_.shape[-1]:
        raise InputError(
            f"L must have shape (..., m, n) and tau (..., n), not {L_.shape} and {tau_.shape}"
        )
    m, n = L_.shape[-2:]
    try:
        stack = np.broadcast_shapes(L_.shape[:-2], tau_.shape[:-1])
        low = np.broadcast_to(_numbers("f_min", f_min), (*stack, m)).reshape(-1, m)
        high = np.broadcast_to(_numbers("f_max", f_max, infinite=True), (*stack, m)).reshape(-1, m)
    except ValueError:
        raise InputError(
            f"L {L_.shape}, tau {tau_.shape}, f_min {np.shape(f_min)} and f_max {np.shape(f_max)} "
            f"do not belong together: bounds are a number or one for each of the {m} muscles"
        ) from None
    _check_bounds(low, high)
    flat = np.broadcast_to(L_, (*stack, m, n)).reshape(-1, m, n)
    tau_flat = np.broadcast_to(tau_, (*stack, n)).reshape(-1, n)
    return Poses(flat, -np.swapaxes(flat, 1, 2), tau_flat, low, high, stack)


def distribution(
    *, finite_bounds: bool = False
) -> Callable[[Callable[..., FloatArray]], Callable[..., DistributedForces]]:
    """Make a distribution over one pose or any stack of poses of a function over flat `Poses`.

    The function returns forces, shape (P, m), in [N]; NaN if it finds none. The distribution is
    called with L, tau, f_min and f_max as `gather` takes them and the function's own options; its
    answer is checked by `finish`.

    Args:
        finite_bounds: Whether the method needs finite upper bounds.
    """

    def decorate(method: Callable[..., FloatArray]) -> Callable[..., DistributedForces]:
        @wraps(method)
        def distribute(
            L: ArrayLike, tau: ArrayLike, f_min: ArrayLike, f_max: ArrayLike, **options: Any
        ) -> DistributedForces:
            poses = gather(L, tau, f_min, f_max)
            if finite_bounds:
                require_finite_bounds(poses, method.__name__)
            return finish(poses, method.__name__, method(poses, **options))

        return distribute

    return decorate


def _numbers(what: str, values: ArrayLike, *, infinite: bool = False) -> FloatArray:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what} must be numbers, not {values!r}") from None
    wrong = np.isnan(array) if infinite else ~np.isfinite(array)
    if wrong.any():
        where = [int(k) for k in np.argwhere(wrong)[0]]
        raise InputError(f"{what}{where or ''} is {array[tuple(where)]}: it must be a number")
    return array


def _check_bounds(low: FloatArray, high: FloatArray) -> None:
    wrong = ~(low <= high) | (low < 0)
    if wrong.any():
        pose, k = (int(i) for i in np.argwhere(wrong)[0])
        raise InputError(
            f"muscle {k + 1}: f_min {low[pose, k]:g} must be at least 0 and at most "
            f"f_max {high[pose, k]:g}"
        )


def require_finite_bounds(poses: Poses, method: str) -> None:
    """Reject unlimited muscles, for methods that need the middle between the bounds.

    Raises:
        InputError: An upper bound is infinite.
    """
    if not np.isfinite(poses.f_max).all():
        k = int(np.argwhere(~np.isfinite(poses.f_max))[0][1])
        raise InputError(f"muscle {k + 1} has no upper bound: {method!r} needs a finite f_max")


def finish(poses: Poses, method: str, forces: FloatArray) -> DistributedForces:
    """Return the checked answer of a method.

    Args:
        poses: The poses.
        method: Name of the distribution.
        forces: Its forces, shape (P, m), in [N]; NaN if it found none.
    """
    scale = np.maximum(1.0, np.where(np.isfinite(poses.f_max), poses.f_max, poses.f_min))
    outside = np.maximum(poses.f_min - forces, forces - poses.f_max)
    near = np.all(outside <= _ROUNDING * scale, axis=1)  # not so for NaN
    clipped = np.clip(forces, poses.f_min, poses.f_max)
    errors, allowed = torque_errors(poses, clipped)
    solved = near & np.all(errors <= allowed, axis=1)
    status = np.where(solved, SOLVED, NO_ANSWER).astype("U10")
    for k in np.flatnonzero(~solved):
        if is_infeasible(poses.A[k], poses.tau[k], poses.f_min[k], poses.f_max[k]):
            status[k] = INFEASIBLE
    return DistributedForces(
        method,
        np.where(solved[:, None], clipped, np.nan).reshape(*poses.stack, poses.m),
        status.reshape(poses.stack),
        np.where(solved, errors.max(axis=1), np.nan).reshape(poses.stack),
    )


def torque_errors(poses: Poses, forces: FloatArray) -> tuple[FloatArray, FloatArray]:
    """|tau + L'f| and how much of it is accepted, both of shape (P, n), in [N·m] or [N]."""
    made = np.einsum("pnm,pm->pn", poses.A, forces)
    terms = np.abs(poses.tau) + np.einsum("pnm,pm->pn", np.abs(poses.A), np.abs(forces))
    terms += _MIN_ROW * terms.max(axis=1, keepdims=True)
    return np.abs(poses.tau - made), _ACCEPTED * terms + np.finfo(float).tiny
