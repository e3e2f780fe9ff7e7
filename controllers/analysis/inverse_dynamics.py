"""Inverse dynamics: muscle forces along a motion, and the strength that muscles need for it.

tau = M(q) qdd + C(q, qd) + G(q) + D qd + w_e,   -L(q)'f = tau,   f_min <= f <= f_max
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from controllers.arrays import BoolArray, FloatArray
from controllers.dynamics import Dynamics, actuator_names, bias_torque, independent_part
from controllers.force_distribution.linear import minimum_infinity_norm
from controllers.force_distribution.methods import distribute
from controllers.force_distribution.one_way import both_ways, one_way
from controllers.force_distribution.poses import DistributedForces

from .wrench_set import torque_margins

_AT_BOUND = 1e-6  # a force this close to a bound is at it, relative to 1 N or the bound
_MAX_MARGIN = 1e6


@dataclass(frozen=True, eq=False)
class Motion:
    """Points of a motion.

    Attributes:
        times: T times that increase, in [s].
        q: Positions, shape (T, n), in [rad] or [m].
        qd: Velocities, shape (T, n), in [rad/s] or [m/s].
        qdd: Accelerations, shape (T, n), in [rad/s²] or [m/s²].
        w_e: Generalised external load, shape (T, n), in [N·m] or [N]; none when None.

    Raises:
        InputError: A size or a number is wrong.
    """

    times: FloatArray
    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    w_e: FloatArray | None = None

    def __post_init__(self) -> None:
        for name in ("times", "q", "qd", "qdd", "w_e"):
            values = getattr(self, name)
            if values is None:
                continue
            try:
                array = np.asarray(values, dtype=np.float64)
            except (TypeError, ValueError):
                raise InputError(f"{name} of the motion must be numbers") from None
            if not np.isfinite(array).all():
                raise InputError(f"{name} of the motion must be finite")
            object.__setattr__(self, name, array)
        T = len(self.times) if self.times.ndim == 1 else 0
        for name in ("q", "qd", "qdd", "w_e"):
            values = getattr(self, name)
            if values is not None and (values.shape != self.q.shape or values.shape[:1] != (T,)):
                raise InputError(f"{name} of the motion has shape {values.shape}, not ({T}, n)")
        if T < 1 or self.q.ndim != 2 or not (np.diff(self.times) > 0).all():
            raise InputError("a motion needs points at times that increase")


@dataclass(frozen=True, eq=False)
class MotionTerms:
    """Torques and muscle Jacobians along a motion.

    Attributes:
        motion: The motion.
        tau: Torque that the muscles must make, shape (T, n), in [N·m] or [N].
        L: Muscle Jacobians, shape (T, m, n), in [m/rad] or [m/m].
        f_min, f_max: Bounds, shape (m,), in [N].
        muscle_names: m names; of the coordinates that have motors behind those of the muscles.
        coordinate_names: n names.
        motors: How many of the m are motors, whose torques may be negative.
    """

    motion: Motion
    tau: FloatArray
    L: FloatArray
    f_min: FloatArray
    f_max: FloatArray
    muscle_names: tuple[str, ...]
    coordinate_names: tuple[str, ...]
    motors: int = 0

    def distribute(self, method: str = "least_squares", **options: Any) -> MotionForces:
        """Return forces along the motion.

        Args:
            method: Name of a distribution, see `controllers.force_distribution`.
            options: Further keyword arguments of the method.

        Raises:
            InputError: The method does not fit the robot, or an option is wrong.
            UnknownNameError: There is no such method or option.
        """
        L, f_min, f_max = one_way(self.L, self.f_min, self.f_max, self.motors)
        found = distribute(L, self.tau, f_min, f_max, method, **options)
        return MotionForces(self, replace(found, forces=both_ways(found.forces, self.motors)))

    def with_bounds(self, f_min: ArrayLike | None, f_max: ArrayLike | None) -> MotionTerms:
        """Return the same with other bounds; None keeps a bound.

        Args:
            f_min: A number or shape (m,), in [N].
            f_max: A number or shape (m,), in [N]; may be infinite.
        """
        low = self.f_min if f_min is None else np.broadcast_to(f_min, self.f_min.shape)
        high = self.f_max if f_max is None else np.broadcast_to(f_max, self.f_max.shape)
        return replace(self, f_min=np.array(low, float), f_max=np.array(high, float))


@dataclass(frozen=True, eq=False)
class MotionForces:
    """Muscle forces along a motion. Points without forces, NaN, count for nothing below.

    Attributes:
        terms: Torques and muscle Jacobians.
        distribution: The forces and their status.
    """

    terms: MotionTerms
    distribution: DistributedForces

    @property
    def forces(self) -> FloatArray:
        """f, shape (T, m), in [N]; NaN if there are none."""
        return self.distribution.forces

    @property
    def solved(self) -> BoolArray:
        """Where there are forces, shape (T,)."""
        return self.distribution.solved

    @property
    def margins(self) -> FloatArray:
        """Distance of every force from the nearer bound, shape (T, m), in [N]."""
        return np.minimum(self.forces - self.terms.f_min, self.terms.f_max - self.forces)

    @property
    def length_rates(self) -> FloatArray:
        """Rates l' = L qd, shape (T, m), in [m/s]; negative if a muscle shortens."""
        rates: FloatArray = np.einsum("tmn,tn->tm", self.terms.L, self.terms.motion.qd)
        return rates

    @property
    def power(self) -> FloatArray:
        """-f l', shape (T, m), in [W]: positive where a muscle shortens and so drives."""
        return -self.forces * self.length_rates

    @cached_property
    def torque_margins(self) -> tuple[FloatArray, FloatArray]:
        """How much more torque each coordinate can have, down and up; both (T, n), in [N·m] or [N].

        Raises:
            InputError: The robot has too many muscles; see `controllers.analysis.wrench_set`.
        """
        terms = self.terms
        L, f_min, f_max = one_way(terms.L, terms.f_min, terms.f_max, terms.motors)
        return torque_margins(L, terms.tau, f_min, f_max)

    def peaks(self) -> FloatArray:
        """Largest |f| of every muscle, shape (m,), in [N]; NaN if no point is solved."""
        return self._over_time(lambda f, axis: np.abs(f).max(axis=axis))

    def rms(self) -> FloatArray:
        """Root mean square of every force over the points, shape (m,), in [N]."""
        return np.sqrt(self._over_time(lambda f, axis: np.mean(f**2, axis=axis)))

    def peak_times(self) -> FloatArray:
        """When every force is largest, shape (m,), in [s]."""
        if not self.solved.any():
            return np.full(self.forces.shape[1], np.nan)
        return np.asarray(self.terms.motion.times[np.nanargmax(np.abs(self.forces), axis=0)])

    def shares_at_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Part of the solved points with a force at f_min, and at f_max; both of shape (m,)."""
        low, high = self.terms.f_min, self.terms.f_max
        near = _AT_BOUND * np.maximum(1.0, np.where(np.isfinite(high), high, low))
        f = self.forces[self.solved]
        count = max(len(f), 1)
        at_min, at_max = f - low <= near, high - f <= near
        return at_min.sum(axis=0) / count, at_max.sum(axis=0) / count

    def _over_time(self, reduce: Any) -> FloatArray:
        if not self.solved.any():
            return np.full(self.forces.shape[1], np.nan)
        return np.asarray(reduce(self.forces[self.solved], axis=0))


def motion_terms(dynamics: Dynamics, motion: Motion) -> MotionTerms:
    """The torques and muscle Jacobians along a motion, with the friction of cables as they go.

    Args:
        dynamics: The robot.
        motion: The motion.

    Raises:
        InputError: The motion has another number of coordinates.
    """
    names = dynamics.coordinate_names
    if motion.q.shape[1] != len(names):
        raise InputError(
            f"the motion has {motion.q.shape[1]} coordinates, the robot {len(names)}: "
            f"{', '.join(names)}"
        )
    tau, L = [], []
    slip = getattr(dynamics, "cable_slip", None)  # of robots whose cables rub
    if slip is not None:
        slip.reset()
    for q, qd, qdd in zip(motion.q, motion.qd, motion.qdd, strict=True):
        own = independent_part(dynamics, qdd)
        tau.append(dynamics.mass_matrix(q) @ own + bias_torque(dynamics, q, qd))
        if slip is not None:
            slip.follow(q)
        L.append(dynamics.actuator_jacobian(q))
    if slip is not None:
        slip.reset()
    load = 0.0 if motion.w_e is None else motion.w_e
    return MotionTerms(
        motion,
        np.array(tau) + load,
        np.array(L),
        dynamics.f_min,
        dynamics.f_max,
        actuator_names(dynamics),
        names,
        len(dynamics.motor_names),
    )


@dataclass(frozen=True, eq=False)
class MuscleSizes:
    """Strength that the muscles need for a motion.

    Attributes:
        forces: Forces within the bounds.
        unlimited: Forces without upper bounds.
        needed: f_max that each muscle needs, shape (m,), in [N], and the effort of each motor, in
            [N·m]: its peak without bounds and the margin. With these every point has these forces.
        least_peaks: Smallest possible force of the strongest muscle, shape (T,), in [N]; NaN if
            not even unlimited muscles will do. No distribution gets along with less.
        margin: Added to the peak, as a part of it.
    """

    forces: MotionForces
    unlimited: MotionForces
    needed: FloatArray
    least_peaks: FloatArray
    margin: float

    @property
    def impossible(self) -> FloatArray:
        """Times at which no strength is enough, in [s]: the muscles pull the wrong way."""
        return np.asarray(self.unlimited.terms.motion.times[~self.unlimited.solved])

    @property
    def critical(self) -> int | None:
        """Index of the point that asks most of the strongest muscle; None if none is solved."""
        return None if np.isnan(self.least_peaks).all() else int(np.nanargmax(self.least_peaks))


def size_muscles(
    terms: MotionTerms, *, margin: float = 0.2, method: str = "least_squares", **options: Any
) -> MuscleSizes:
    """Strength that the muscles need: their forces without upper bounds.

    Args:
        terms: Torques and muscle Jacobians along the motion.
        margin: Added to a peak, as a part of it, from 0 to 1e6.
        method: Name of the distribution; one that allows unlimited muscles.
        options: Further keyword arguments of the method.

    Raises:
        InputError: The margin is wrong, or the method needs upper bounds.
    """
    if not 0.0 <= margin <= _MAX_MARGIN:
        raise InputError(f"margin must be within 0 and {_MAX_MARGIN:g}: {margin}")
    muscles = len(terms.f_min) - terms.motors
    open_ways = np.full(terms.motors, -np.inf)
    lifted = terms.with_bounds(np.concatenate([terms.f_min[:muscles], open_ways]), np.inf)
    unlimited = lifted.distribute(method, **options)
    L, f_min, f_max = one_way(lifted.L, lifted.f_min, lifted.f_max, terms.motors)
    counts = (np.arange(len(f_min)) < muscles).astype(float)
    least = minimum_infinity_norm(L, lifted.tau, f_min, f_max, counts=counts)
    return MuscleSizes(
        terms.distribute(method, **options),
        unlimited,
        np.maximum((1.0 + margin) * unlimited.peaks(), terms.f_min),
        least.forces[:, :muscles].max(axis=1, initial=0.0),
        margin,
    )
