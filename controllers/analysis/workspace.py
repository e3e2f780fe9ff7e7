"""Workspace analysis: conditions and metrics on a grid of poses.

    wrench closure:   Muscles without upper force limits can produce every torque.
    static:           Forces within the limits hold the robot at rest.
    wrench-feasible:  Forces within the limits hold the robot against every load of a set.
    dynamic:          Forces within the limits produce every acceleration of a set.

These are the workspace conditions of CASPR. For the terms see Ebert-Uphoff, Voglewede, "On the
connections between cable-driven parallel manipulators and grasping", ICRA 2004.

The module `wrench_set` defines the arguments L, tau, f_min, f_max and half_widths.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, UnknownNameError
from controllers.arrays import BoolArray, FloatArray
from controllers.dynamics import Dynamics
from controllers.force_distribution.motor_columns import split_motors
from controllers.force_distribution.quadratic import least_squares

from .workspace_metrics import condition_number, tension_factor, unilateral_dexterity
from .wrench_set import capacity_margin, has_wrench_closure, too_many_facets

_ROUNDING = 1e-9  # largest negative margin that is treated as 0, relative to the torques
_MIN_TENSION_FACTOR = 1e-9  # wrench closure requires a larger tension factor
_MAX_CORNERS = 4096


@dataclass(frozen=True, eq=False)
class Workspace:
    """Conditions and metrics at the poses of a grid.

    Attributes:
        q: The poses, shape (..., n), in [rad] or [m].
        conditions: Whether each condition holds, shape (...), by name.
        metrics: Values of each metric, shape (...), by name.
    """

    q: FloatArray
    conditions: Mapping[str, BoolArray]
    metrics: Mapping[str, FloatArray]

    def share(self, condition: str) -> float:
        """Return the fraction of the poses that fulfil a condition, from 0 to 1.

        Raises:
            UnknownNameError: The condition was not evaluated.
        """
        if condition not in self.conditions:
            raise UnknownNameError("condition", condition, self.conditions)
        return float(np.mean(self.conditions[condition]))


def joint_grid(lower: ArrayLike, upper: ArrayLike, points: int | Sequence[int]) -> FloatArray:
    """Return a regular grid of poses.

    Args:
        lower: Smallest q, shape (n,), in [rad] or [m].
        upper: Largest q, shape (n,).
        points: Number of poses along each coordinate, or along all.

    Returns:
        Shape (points_1, ..., points_n, n).

    Raises:
        InputError: A size is wrong, or a limit is not finite.
    """
    low, high = np.atleast_1d(np.asarray(lower, float)), np.atleast_1d(np.asarray(upper, float))
    counts = [points] * len(low) if isinstance(points, int) else list(points)
    if low.ndim != 1 or low.shape != high.shape or len(counts) != len(low):
        raise InputError("lower, upper and points must have equal lengths")
    if not (np.isfinite(low) & np.isfinite(high) & (low <= high)).all():
        raise InputError(f"lower {low} and upper {high} must be finite, with lower <= upper")
    if any(int(count) != count or count < 1 for count in counts):
        raise InputError(f"points must be positive integers, not {points!r}")
    axes = [np.linspace(a, b, int(k)) for a, b, k in zip(low, high, counts, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def is_wrench_closed(L: ArrayLike) -> BoolArray:
    """Return whether muscles without upper force limits can produce every torque, shape (...).

    Any number of muscles is allowed. The result is True without coordinates, and False if there are
    coordinates but no muscles.
    """
    shape = np.shape(L)
    if len(shape) >= 2 and too_many_facets(shape[-2], shape[-1]):
        return np.asarray(tension_factor(L) > _MIN_TENSION_FACTOR)
    return has_wrench_closure(L)


def is_wrench_feasible(
    L: ArrayLike,
    tau: ArrayLike,
    f_min: ArrayLike,
    f_max: ArrayLike,
    *,
    half_widths: ArrayLike | None = None,
) -> BoolArray:
    """Return whether the force limits allow every torque tau + W s with |s_j| <= 1, shape (...).

    The function uses the facets of the set of available torques. If there are too many facets, or
    if the muscles do not act on all coordinates independently, it checks the corners of the set of
    desired torques at every pose.

    Raises:
        InputError: A size is wrong, a number is out of range, or there are too many corners.
    """
    L_, tau_ = np.asarray(L, dtype=np.float64), np.asarray(tau, dtype=np.float64)
    if half_widths is None or too_many_facets(*L_.shape[-2:]):
        return _feasible_at_corners(L_, tau_, f_min, f_max, half_widths)
    margin = capacity_margin(L_, tau_, f_min, f_max, half_widths=half_widths)
    size = np.abs(tau_).max(axis=-1) + np.abs(L_).max(axis=(-2, -1)) * np.max(f_min)
    holds = margin >= -_ROUNDING * size
    if np.isnan(margin).any():
        corners = _feasible_at_corners(L_, tau_, f_min, f_max, half_widths)
        holds = np.where(np.isnan(margin), corners, holds)
    return np.asarray(holds)


def _feasible_at_corners(
    L: FloatArray,
    tau: FloatArray,
    f_min: ArrayLike,
    f_max: ArrayLike,
    half_widths: ArrayLike | None,
) -> BoolArray:
    """Return whether the force limits allow all corners of the desired torques.

    This suffices, since the set of available torques is convex.
    """
    if half_widths is None:
        return least_squares(L, tau, f_min, f_max).solved
    W = np.asarray(half_widths, dtype=np.float64)
    if 2 ** W.shape[-1] > _MAX_CORNERS:
        raise InputError(
            f"half_widths define 2^{W.shape[-1]} corners; the maximum is {_MAX_CORNERS}"
        )
    signs = product((-1.0, 1.0), repeat=W.shape[-1])
    corners = (tau + np.einsum("...nk,k->...n", W, np.array(s)) for s in signs)
    answers = [least_squares(L, corner, f_min, f_max).solved for corner in corners]
    return np.asarray(np.logical_and.reduce(answers))


METRICS: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "condition_number": condition_number,
    "tension_factor": tension_factor,
    "unilateral_dexterity": unilateral_dexterity,
}
"""Metrics that depend only on L, by name. `capacity_margin` also depends on torques and limits."""

CONDITIONS = ("wrench_closure", "static", "wrench_feasible", "dynamic")


def workspace(
    dynamics: Dynamics,
    q: ArrayLike,
    *,
    conditions: Sequence[str] = ("wrench_closure", "static"),
    metrics: Sequence[str] = (),
    loads: ArrayLike | None = None,
    accelerations: ArrayLike | None = None,
) -> Workspace:
    """Evaluate conditions and metrics at the poses of a grid.

    Args:
        q: Poses, shape (..., n), in [rad] or [m]; see `joint_grid`.
        conditions: Names from `CONDITIONS`.
        metrics: Names from `METRICS`, or `capacity_margin`. The capacity margin includes the loads
            if they are specified.
        loads: Largest load w_e of each coordinate in addition to gravity, for `wrench_feasible`: a
            number or shape (n,), in [N·m] or [N]. The set includes both signs.
        accelerations: Largest acceleration of each coordinate from rest, for `dynamic`: a number or
            shape (n,), in [rad/s²] or [m/s²]. The set includes both signs.

    Raises:
        InputError: A size is wrong, a number is out of range, or a required set is missing.
        UnknownNameError: A condition or a metric does not exist.
    """
    _check_names(conditions, metrics)
    n = len(dynamics.coordinate_names)
    poses = np.asarray(q, dtype=np.float64)
    if poses.ndim < 1 or poses.shape[-1] != n or not np.isfinite(poses).all():
        raise InputError(f"q must be finite with shape (..., {n}), not {poses.shape}")
    flat = poses.reshape(-1, n)
    L = np.array([dynamics.actuator_jacobian(p) for p in flat]).reshape(len(flat), -1, n)
    G = np.array([dynamics.gravity(p) for p in flat]).reshape(-1, n)
    motors = len(dynamics.motor_names)
    L, *bounds = split_motors(L, dynamics.f_min, dynamics.f_max, motors)
    box = None if loads is None else np.diag(_half_widths("loads", loads, n))

    def holds(condition: str) -> BoolArray:
        if condition == "wrench_closure":
            return is_wrench_closed(L)
        if condition == "static":
            return is_wrench_feasible(L, G, *bounds)
        if condition == "wrench_feasible":
            return is_wrench_feasible(L, G, *bounds, half_widths=_required("loads", box))
        a = np.diag(_half_widths("accelerations", _required("accelerations", accelerations), n))
        M = np.array([dynamics.mass_matrix(p) for p in flat]).reshape(-1, n, n)
        return is_wrench_feasible(L, G, *bounds, half_widths=M @ a)

    def value(metric: str) -> FloatArray:
        if metric == "capacity_margin":
            return capacity_margin(L, G, *bounds, half_widths=box)
        return METRICS[metric](L)

    grid = poses.shape[:-1]
    return Workspace(
        poses,
        {name: holds(name).reshape(grid) for name in conditions},
        {name: value(name).reshape(grid) for name in metrics},
    )


def _check_names(conditions: Sequence[str], metrics: Sequence[str]) -> None:
    for name in conditions:
        if name not in CONDITIONS:
            raise UnknownNameError("condition", name, CONDITIONS)
    for name in metrics:
        if name not in METRICS and name != "capacity_margin":
            raise UnknownNameError("metric", name, (*METRICS, "capacity_margin"))


def _required(name: str, value: ArrayLike | None) -> ArrayLike:
    if value is None:
        raise InputError(f"this condition requires {name}")
    return value


def _half_widths(name: str, values: ArrayLike, n: int) -> FloatArray:
    try:
        widths = np.broadcast_to(np.asarray(values, dtype=np.float64), (n,))
    except (TypeError, ValueError):
        raise InputError(f"{name} must be a number or {n} numbers, not {values!r}") from None
    if not (np.isfinite(widths) & (widths >= 0)).all():
        raise InputError(f"{name} must be finite and not negative: {values!r}")
    return np.asarray(widths)
