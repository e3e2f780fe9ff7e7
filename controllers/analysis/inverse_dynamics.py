"""Inverse dynamics: muscle forces along a motion, and the muscle strength that it requires.

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
from controllers.force_distribution.motor_columns import merge_motors, split_motors
from controllers.force_distribution.poses import DistributedForces

from .wrench_set import torque_margins

_AT_LIMIT = 1e-6  # maximum distance of a force that is at its limit, relative to 1 N or the limit
_MAX_MARGIN = 1e6


@dataclass(frozen=True, eq=False)
class Motion:
    """Points of a motion.

    Attributes:
        times: T increasing times, in [s].
        q: Positions, shape (T, n), in [rad] or [m].
        qd: Velocities, shape (T, n), in [rad/s] or [m/s].
        qdd: Accelerations, shape (T, n), in [rad/s²] or [m/s²].
        w_e: Generalised external load, shape (T, n), in [N·m] or [N], or None.

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
            raise InputError("a motion requires points at increasing times")


@dataclass(frozen=True, eq=False)
class MotionTerms:
    """Torques and muscle Jacobians along a motion.

    Attributes:
        tau: Torque that the muscles must produce, shape (T, n), in [N·m] or [N].
        L: Muscle Jacobians, shape (T, m, n), in [m/rad] or [m/m].
        f_min, f_max: Force limits, shape (m,), in [N].
        muscle_names: m names. The coordinates with motors follow the muscles.
        coordinate_names: n names.
        motors: Number of motors among the m actuators. Their torques may be negative.
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
        """Compute forces along the motion.

        Args:
            method: Name of a distribution, see `controllers.force_distribution`.
            options: Further keyword arguments of the method.

        Raises:
            InputError: The method does not fit the robot, or an option is wrong.
            UnknownNameError: The method or an option does not exist.
        """
        L, f_min, f_max = split_motors(self.L, self.f_min, self.f_max, self.motors)
        result = distribute(L, self.tau, f_min, f_max, method, **options)
        return MotionForces(self, replace(result, forces=merge_motors(result.forces, self.motors)))

    def with_bounds(self, f_min: ArrayLike | None, f_max: ArrayLike | None) -> MotionTerms:
        """Return a copy with other force limits; None keeps a limit.

        Args:
            f_min: A number or shape (m,), in [N].
            f_max: A number or shape (m,), in [N]; may be infinite.
        """
        low = self.f_min if f_min is None else np.broadcast_to(f_min, self.f_min.shape)
        high = self.f_max if f_max is None else np.broadcast_to(f_max, self.f_max.shape)
        return replace(self, f_min=np.array(low, float), f_max=np.array(high, float))


@dataclass(frozen=True, eq=False)
class MotionForces:
    """Muscle forces along a motion. The statistics ignore unsolved points, whose forces are NaN.

    Attributes:
        terms: Torques and muscle Jacobians.
        distribution: The forces and their status.
    """

    terms: MotionTerms
    distribution: DistributedForces

    @property
    def forces(self) -> FloatArray:
        """f, shape (T, m), in [N]; NaN at unsolved points."""
        return self.distribution.forces

    @property
    def solved(self) -> BoolArray:
        """Whether each point is solved, shape (T,)."""
        return self.distribution.solved

    @property
    def margins(self) -> FloatArray:
        """Distance of every force from the nearer limit, shape (T, m), in [N]."""
        return np.minimum(self.forces - self.terms.f_min, self.terms.f_max - self.forces)

    @property
    def length_rates(self) -> FloatArray:
        """Rates l' = L qd, shape (T, m), in [m/s]; negative if a muscle shortens."""
        rates: FloatArray = np.einsum("tmn,tn->tm", self.terms.L, self.terms.motion.qd)
        return rates

    @property
    def power(self) -> FloatArray:
        """Muscle power -f l', shape (T, m), in [W]; positive when a muscle shortens."""
        return -self.forces * self.length_rates

    @cached_property
    def torque_margins(self) -> tuple[FloatArray, FloatArray]:
        """Torque reserves of each coordinate, down and up, shape (T, n) each, in [N·m] or [N].

        Raises:
            InputError: The robot has too many muscles; see `controllers.analysis.wrench_set`.
        """
        terms = self.terms
        L, f_min, f_max = split_motors(terms.L, terms.f_min, terms.f_max, terms.motors)
        return torque_margins(L, terms.tau, f_min, f_max)

    def peaks(self) -> FloatArray:
        """Return the largest |f| of every muscle, shape (m,), in [N]; NaN if no point is solved."""
        return self._over_time(lambda f, axis: np.abs(f).max(axis=axis))

    def rms(self) -> FloatArray:
        """Return the root mean square of every force over the points, shape (m,), in [N]."""
        return np.sqrt(self._over_time(lambda f, axis: np.mean(f**2, axis=axis)))

    def peak_times(self) -> FloatArray:
        """Return the time of the largest force of every muscle, shape (m,), in [s]."""
        if not self.solved.any():
            return np.full(self.forces.shape[1], np.nan)
        return np.asarray(self.terms.motion.times[np.nanargmax(np.abs(self.forces), axis=0)])

    def shares_at_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the fractions of solved points with forces at f_min and f_max, shape (m,) each."""
        low, high = self.terms.f_min, self.terms.f_max
        near = _AT_LIMIT * np.maximum(1.0, np.where(np.isfinite(high), high, low))
        f = self.forces[self.solved]
        count = max(len(f), 1)
        at_min, at_max = f - low <= near, high - f <= near
        return at_min.sum(axis=0) / count, at_max.sum(axis=0) / count

    def _over_time(self, reduce: Any) -> FloatArray:
        if not self.solved.any():
            return np.full(self.forces.shape[1], np.nan)
        return np.asarray(reduce(self.forces[self.solved], axis=0))


def motion_terms(dynamics: Dynamics, motion: Motion) -> MotionTerms:
    """Compute torques and muscle Jacobians along a motion, including cable friction.

    Raises:
        InputError: The motion and the robot differ in the number of coordinates.
    """
    names = dynamics.coordinate_names
    if motion.q.shape[1] != len(names):
        raise InputError(
            f"the motion has {motion.q.shape[1]} coordinates, the robot has {len(names)}: "
            f"{', '.join(names)}"
        )
    tau, L = [], []
    slip = getattr(
        dynamics, "cable_slip", None
    )  # only robots with cable friction have this attribute
    if slip is not None:
        slip.reset()
    for q, qd, qdd in zip(motion.q, motion.qd, motion.qdd, strict=True):
        independent_qdd = independent_part(dynamics, qdd)
        tau.append(dynamics.mass_matrix(q) @ independent_qdd + bias_torque(dynamics, q, qd))
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
    """Muscle strength that a motion requires.

    Attributes:
        forces: Forces within the force limits.
        unlimited: Forces without upper limits.
        needed: Required f_max of each muscle, shape (m,), in [N], and required effort of each
            motor, in [N·m]: the peak of `unlimited`, increased by the margin.
        min_peaks: Smallest possible force of the most loaded muscle, shape (T,), in [N]; NaN if
            unlimited muscles cannot produce the torque. No distribution has a lower peak.
        margin: Relative increase of the peak.
    """

    forces: MotionForces
    unlimited: MotionForces
    needed: FloatArray
    min_peaks: FloatArray
    margin: float

    @property
    def impossible(self) -> FloatArray:
        """Times at which muscles of any strength cannot produce the torque, in [s]."""
        return np.asarray(self.unlimited.terms.motion.times[~self.unlimited.solved])

    @property
    def critical(self) -> int | None:
        """Index of the point with the largest of `min_peaks`, or None if no point is solved."""
        return None if np.isnan(self.min_peaks).all() else int(np.nanargmax(self.min_peaks))


def size_muscles(
    terms: MotionTerms, *, margin: float = 0.2, method: str = "least_squares", **options: Any
) -> MuscleSizes:
    """Compute the muscle strength that a motion requires, from forces without upper limits.

    Args:
        terms: Torques and muscle Jacobians along the motion.
        margin: Relative increase of the peak, from 0 to 1e6.
        method: Name of a distribution that allows unlimited muscles.
        options: Further keyword arguments of the method.

    Raises:
        InputError: The margin is out of range, or the method requires upper limits.
    """
    if not 0.0 <= margin <= _MAX_MARGIN:
        raise InputError(f"margin must be between 0 and {_MAX_MARGIN:g}: {margin}")
    muscles = len(terms.f_min) - terms.motors
    no_limits = np.full(terms.motors, -np.inf)
    lifted = terms.with_bounds(np.concatenate([terms.f_min[:muscles], no_limits]), np.inf)
    unlimited = lifted.distribute(method, **options)
    L, f_min, f_max = split_motors(lifted.L, lifted.f_min, lifted.f_max, terms.motors)
    is_muscle = (np.arange(len(f_min)) < muscles).astype(float)
    minimal = minimum_infinity_norm(L, lifted.tau, f_min, f_max, counts=is_muscle)
    return MuscleSizes(
        terms.distribute(method, **options),
        unlimited,
        np.maximum((1.0 + margin) * unlimited.peaks(), terms.f_min),
        minimal.forces[:, :muscles].max(axis=1, initial=0.0),
        margin,
    )
