"""Stacks of poses, and checked forces of a distribution with a status for each pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from addin_sdfusion.robot import InputError
from controllers.arrays import BoolArray, FloatArray
from controllers.validation import float_array

from .feasibility import is_infeasible

SOLVED = "solved"
INFEASIBLE = "infeasible"
NO_ANSWER = "no answer"

_MAX_TORQUE_ERROR = 1e-8  # of a solution, relative to the sum of the magnitudes of its terms
_MAX_VIOLATION = 1e-7  # of a force limit by rounding, relative to 1 N or the limit
_MIN_ROW = 1e-6  # minimum size of a row for the torque error, relative to the largest row


class Poses(NamedTuple):
    """Force distribution problems of P poses: A f = tau with A = -L', f_min <= f <= f_max.

    Attributes:
        L: Muscle Jacobians, shape (P, m, n), in [m/rad] or [m/m].
        A: -L', shape (P, n, m).
        tau: Desired torques, shape (P, n), in [N·m] or [N].
        f_min, f_max: Force limits, shape (P, m), in [N].
        stack: Original shape of the stack of poses.
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
        """Mean of the force limits, shape (P, m), in [N]."""
        return 0.5 * (self.f_min + self.f_max)

    def only(self, chosen: BoolArray) -> Poses:
        """Return the chosen poses as a flat stack."""
        L, A, tau, f_min, f_max, _ = self
        stack = (int(chosen.sum()),)
        return Poses(L[chosen], A[chosen], tau[chosen], f_min[chosen], f_max[chosen], stack)


@dataclass(frozen=True, eq=False)
class DistributedForces:
    """Muscle forces for one pose or a stack of poses.

    Attributes:
        method: Name of the distribution.
        forces: f within the force limits, shape (..., m), in [N]; NaN if not solved.
        status: Status of each pose, shape (...): `solved`; `infeasible` if no forces within the
            limits produce the torque; `no answer` if forces exist, but the method did not find
            them.
        torque_error: Largest |tau + L'f| of a coordinate, shape (...), in [N·m] or [N].
    """

    method: str
    forces: FloatArray
    status: NDArray[np.str_]
    torque_error: FloatArray

    @property
    def solved(self) -> BoolArray:
        """Whether each pose is solved, shape (...)."""
        return np.asarray(self.status == SOLVED)


def gather(L: ArrayLike, tau: ArrayLike, f_min: ArrayLike, f_max: ArrayLike) -> Poses:
    """Check a stack of poses of any shape and return it flattened.

    Args:
        L: Muscle Jacobians, shape (..., m, n), in [m/rad] or [m/m].
        tau: Desired torques, shape (..., n), in [N·m] or [N].
        f_min: Lower limits, a number, shape (m,) or (..., m), in [N].
        f_max: Upper limits, a number, shape (m,) or (..., m), in [N]; may be infinite.

    Raises:
        InputError: A size is wrong, or a number is out of range.
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
            f"have inconsistent shapes; f_min and f_max must be a number or {m} numbers"
        ) from None
    _check_bounds(low, high)
    flat = np.broadcast_to(L_, (*stack, m, n)).reshape(-1, m, n)
    tau_flat = np.broadcast_to(tau_, (*stack, n)).reshape(-1, n)
    return Poses(flat, -np.swapaxes(flat, 1, 2), tau_flat, low, high, stack)


def distribution(
    *, finite_bounds: bool = False
) -> Callable[[Callable[..., FloatArray]], Callable[..., DistributedForces]]:
    """Return a decorator that extends a function of `Poses` to any stack of poses.

    The function returns forces, shape (P, m), in [N]; NaN if it finds none. The decorated function
    has the arguments L, tau, f_min and f_max of `gather`, and the options of the function.
    `check_forces` checks the result.

    Args:
        finite_bounds: Whether the method requires finite upper limits.
    """

    def decorate(method: Callable[..., FloatArray]) -> Callable[..., DistributedForces]:
        @wraps(method)
        def distribute(
            L: ArrayLike, tau: ArrayLike, f_min: ArrayLike, f_max: ArrayLike, **options: Any
        ) -> DistributedForces:
            poses = gather(L, tau, f_min, f_max)
            if finite_bounds:
                require_finite_bounds(poses, method.__name__)
            return check_forces(poses, method.__name__, method(poses, **options))

        return distribute

    return decorate


def _numbers(name: str, values: ArrayLike, *, infinite: bool = False) -> FloatArray:
    array = float_array(name, values)
    wrong = np.isnan(array) if infinite else ~np.isfinite(array)
    if wrong.any():
        index = [int(k) for k in np.argwhere(wrong)[0]]
        allowed = "a number" if infinite else "finite"
        raise InputError(f"{name}{index or ''} must be {allowed}, not {array[tuple(index)]}")
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
    """Reject muscles without upper limits, for methods that use the mean of the limits.

    Raises:
        InputError: An upper limit is infinite.
    """
    if not np.isfinite(poses.f_max).all():
        k = int(np.argwhere(~np.isfinite(poses.f_max))[0][1])
        raise InputError(f"muscle {k + 1}: f_max must be finite for {method!r}")


def check_forces(poses: Poses, method: str, forces: FloatArray) -> DistributedForces:
    """Check the forces of a method and return them with a status for each pose.

    Args:
        forces: Forces of the method, shape (P, m), in [N]; NaN if it found none.
    """
    scale = np.maximum(1.0, np.where(np.isfinite(poses.f_max), poses.f_max, poses.f_min))
    outside = np.maximum(poses.f_min - forces, forces - poses.f_max)
    near = np.all(outside <= _MAX_VIOLATION * scale, axis=1)  # False for NaN
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
    """Return |tau + L'f| and its tolerance, shape (P, n) each, in [N·m] or [N]."""
    produced = np.einsum("pnm,pm->pn", poses.A, forces)
    terms = np.abs(poses.tau) + np.einsum("pnm,pm->pn", np.abs(poses.A), np.abs(forces))
    terms += _MIN_ROW * terms.max(axis=1, keepdims=True)
    return np.abs(poses.tau - produced), _MAX_TORQUE_ERROR * terms + np.finfo(float).tiny
