"""Workspace analysis: conditions and metrics on a grid of poses.

Wrench closure: unlimited muscles could make any torque. Static: the bounds allow forces that hold
the robot at rest. Wrench-feasible: they do so against every load of a set. Dynamic: they give it
every acceleration of a set. CASPR's workspace conditions; for the terms see Ebert-Uphoff,
Voglewede, "On the connections between cable-driven parallel manipulators and grasping", ICRA 2004.

L, tau, f_min, f_max and half_widths are those of `wrench_set`.
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
from controllers.force_distribution.one_way import one_way
from controllers.force_distribution.quadratic import least_squares

from .workspace_metrics import condition_number, tension_factor, unilateral_dexterity
from .wrench_set import capacity_margin, has_wrench_closure, too_many_facets

_ROUNDING = 1e-9  # a margin this little below 0 is rounding, relative to the torques
_CLOSED = 1e-9  # a tension factor above this is wrench closure
_MAX_CORNERS = 4096


@dataclass(frozen=True, eq=False)
class Workspace:
    """Conditions and metrics at the poses of a grid.

    Attributes:
        q: The poses, shape (..., n), in [rad] or [m].
        conditions: By name, whether they hold, shape (...).
        metrics: By name, their values, shape (...).
    """

    q: FloatArray
    conditions: Mapping[str, BoolArray]
    metrics: Mapping[str, FloatArray]

    def share(self, condition: str) -> float:
        """Return the part of the poses where a condition holds, from 0 to 1.

        Raises:
            UnknownNameError: It was not looked at.
        """
        if condition not in self.conditions:
            raise UnknownNameError("condition", condition, self.conditions)
        return float(np.mean(self.conditions[condition]))


def joint_grid(lower: ArrayLike, upper: ArrayLike, points: int | Sequence[int]) -> FloatArray:
    """Return a regular grid of poses.

    Args:
        lower: Smallest q, shape (n,), in [rad] or [m].
        upper: Largest q, shape (n,).
        points: How many along each coordinate, or along all.

    Returns:
        Shape (points_1, ..., points_n, n).

    Raises:
        InputError: A size or a number is wrong, such as a joint without limits.
    """
    low, high = np.atleast_1d(np.asarray(lower, float)), np.atleast_1d(np.asarray(upper, float))
    counts = [points] * len(low) if isinstance(points, int) else list(points)
    if low.ndim != 1 or low.shape != high.shape or len(counts) != len(low):
        raise InputError("lower, upper and points must be equally long")
    if not (np.isfinite(low) & np.isfinite(high) & (low <= high)).all():
        raise InputError(f"a grid needs finite limits, lower below upper, not {low} and {high}")
    if any(int(count) != count or count < 1 for count in counts):
        raise InputError(f"points must be whole numbers of at least 1, not {points!r}")
    axes = [np.linspace(a, b, int(k)) for a, b, k in zip(low, high, counts, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def is_wrench_closed(L: ArrayLike) -> BoolArray:
    """Whether unlimited muscles could make any torque, shape (...), for any number of muscles.

    Without muscles none is made; without coordinates there is none to make, and all is well.
    """
    shape = np.shape(L)
    if len(shape) >= 2 and too_many_facets(shape[-2], shape[-1]):
        return np.asarray(tension_factor(L) > _CLOSED)
    return has_wrench_closure(L)


def is_wrench_feasible(
    L: ArrayLike,
    tau: ArrayLike,
    f_min: ArrayLike,
    f_max: ArrayLike,
    *,
    half_widths: ArrayLike | None = None,
) -> BoolArray:
    """Return whether the bounds allow every torque tau + W s with |s_j| <= 1, shape (...).

    By the facets of the available torques; pose by pose over the corners of the desired ones where
    the facets are too many or the muscles do not act on all coordinates independently.

    Raises:
        InputError: A size or a number is wrong, or there are too many corners.
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
    """Return whether the bounds allow all corners of the desired torques; the set is convex."""
    if half_widths is None:
        return least_squares(L, tau, f_min, f_max).solved
    W = np.asarray(half_widths, dtype=np.float64)
    if 2 ** W.shape[-1] > _MAX_CORNERS:
        raise InputError(f"half_widths make 2^{W.shape[-1]} corners, too many")
    signs = product((-1.0, 1.0), repeat=W.shape[-1])
    corners = (tau + np.einsum("...nk,k->...n", W, np.array(s)) for s in signs)
    answers = [least_squares(L, corner, f_min, f_max).solved for corner in corners]
    return np.asarray(np.logical_and.reduce(answers))


METRICS: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "condition_number": condition_number,
    "tension_factor": tension_factor,
    "unilateral_dexterity": unilateral_dexterity,
}
"""Metrics of L alone by name; `capacity_margin` needs the torques and bounds as well."""

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
    """Conditions and metrics at the poses of a grid.

    Args:
        dynamics: The robot.
        q: Poses, shape (..., n), in [rad] or [m]; see `joint_grid`.
        conditions: Of `CONDITIONS`.
        metrics: Of `METRICS`, or `capacity_margin`: that of the set of loads, or of rest.
        loads: Of `wrench_feasible`: the loads w_e from -loads to loads of every coordinate, beside
            gravity, a number or shape (n,), in [N·m] or [N].
        accelerations: Of `dynamic`: accelerations from -a to a of every coordinate from rest, a
            number or shape (n,), in [rad/s²] or [m/s²].

    Raises:
        InputError: A size or a number is wrong, or a set is missing.
        UnknownNameError: There is no such condition or metric.
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
    L, *bounds = one_way(L, dynamics.f_min, dynamics.f_max, motors)
    box = None if loads is None else np.diag(_half_widths("loads", loads, n))

    def holds(condition: str) -> BoolArray:
        if condition == "wrench_closure":
            return is_wrench_closed(L)
        if condition == "static":
            return is_wrench_feasible(L, G, *bounds)
        if condition == "wrench_feasible":
            return is_wrench_feasible(L, G, *bounds, half_widths=_given("loads", box))
        a = np.diag(_half_widths("accelerations", _given("accelerations", accelerations), n))
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


def _given(what: str, value: ArrayLike | None) -> ArrayLike:
    if value is None:
        raise InputError(f"this condition requires {what}")
    return value


def _half_widths(what: str, values: ArrayLike, n: int) -> FloatArray:
    try:
        widths = np.broadcast_to(np.asarray(values, dtype=np.float64), (n,))
    except (TypeError, ValueError):
        raise InputError(f"{what} must be a number or {n} numbers, not {values!r}") from None
    if not (np.isfinite(widths) & (widths >= 0)).all():
        raise InputError(f"{what} must be finite and not negative: {values!r}")
    return np.asarray(widths)
