"""Robot dynamics for controllers: the terms of M(q) qdd + C + G = -L(q)'f.

The vector f contains muscle forces, followed by the torques of motors at joints. A motor torque may
be negative. The row of L of a motor has one nonzero entry, -1 in the column of its coordinate.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .arrays import FloatArray


class Dynamics(Protocol):
    """Dynamics of a robot with n coordinates and a actuators: m muscles, and motors of joints.

    Attributes:
        coordinate_names: n names, in the order of q.
        muscle_names: m names, in the order of f.
        motor_names: Names of the coordinates that have motors, in the order of q.
        f_min, f_max: Force limits of the muscles, followed by torque limits of the motors, shape
            (a,), in [N] and [N·m].
        damping: Viscous joint damping, shape (n,), in [N·m·s/rad] or [N·s/m].
    """

    @property
    def coordinate_names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def muscle_names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def motor_names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def f_min(self) -> FloatArray: ...  # noqa: D102
    @property
    def f_max(self) -> FloatArray: ...  # noqa: D102
    @property
    def damping(self) -> FloatArray: ...  # noqa: D102

    def mass_matrix(self, q: FloatArray) -> FloatArray:
        """Return M(q), shape (n, n)."""

    def coriolis(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        """Return C(q, qd), shape (n,)."""

    def gravity(self, q: FloatArray) -> FloatArray:
        """Return G(q), shape (n,)."""

    def muscle_jacobian(self, q: FloatArray) -> FloatArray:
        """Return L(q) = dl/dq, shape (m, n)."""

    def actuator_jacobian(self, q: FloatArray) -> FloatArray:
        """Return L(q), followed by one row per motor, shape (a, n). f produces the torque -L'f."""


class LimitedDynamics(Dynamics, Protocol):
    """Dynamics of a robot with joint limits.

    Attributes:
        q_min, q_max: Joint limits, shape (n,), in [rad] or [m]; infinite if unlimited.
    """

    @property
    def q_min(self) -> FloatArray: ...  # noqa: D102
    @property
    def q_max(self) -> FloatArray: ...  # noqa: D102


class PathDynamics(LimitedDynamics, Protocol):
    """Dynamics of a robot that also provides its muscle lengths."""

    def muscle_lengths(self, q: FloatArray) -> FloatArray:
        """Return l(q), shape (m,), in [m]."""


class TaskDynamics(LimitedDynamics, Protocol):
    """Dynamics of a robot with an operational space of k task coordinates.

    Attributes:
        task_names: k names, in the order of y, such as `hand.x`.
        task_angles: Whether each task coordinate is an angle, shape (k,).
    """

    @property
    def task_names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def task_angles(self) -> NDArray[np.bool_]: ...  # noqa: D102

    def task_position(self, q: FloatArray) -> FloatArray:
        """Return y(q), shape (k,)."""

    def task_jacobian(self, q: FloatArray) -> FloatArray:
        """Return J(q) = dy/dq, shape (k, n)."""

    def task_bias(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        """Return J'(q, qd) qd, shape (k,)."""


def actuator_names(dynamics: Dynamics) -> tuple[str, ...]:
    """Return the names of all muscles and of all coordinates with motors, in the order of f."""
    return (*dynamics.muscle_names, *dynamics.motor_names)


def bias_torque(dynamics: Dynamics, q: FloatArray, qd: FloatArray) -> FloatArray:
    """Compute C(q, qd) + G(q) + D qd, the equation of motion without inertia and muscles.

    Args:
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].

    Returns:
        Torque, shape (n,), in [N·m] or [N].
    """
    torque: FloatArray = dynamics.coriolis(q, qd) + dynamics.gravity(q) + dynamics.damping * qd
    return torque


def task_error(dynamics: TaskDynamics, q: FloatArray, y_d: FloatArray) -> FloatArray:
    """Return y_d - y(q), with angles wrapped to [-pi, pi), shape (k,), in [m] or [rad]."""
    error: FloatArray = y_d - dynamics.task_position(q)
    angles = dynamics.task_angles
    error[angles] = np.remainder(error[angles] + np.pi, 2.0 * np.pi) - np.pi
    return error


def close_loops(dynamics: Dynamics, q: FloatArray) -> FloatArray:
    """Close kinematic loops by changing the dependent coordinates of q, shape (n,).

    Dynamics of a robot with loops have a method `closed`. Without it, q is returned unchanged.
    """
    close = getattr(dynamics, "closed", None)
    return q if close is None else np.asarray(close(q), dtype=np.float64)


def independent_part(dynamics: Dynamics, values: FloatArray) -> FloatArray:
    """Return values with 0 for coordinates that depend on others through loops, shape (n,)."""
    dependent = getattr(dynamics, "dependent", None)
    return values if dependent is None else np.where(dependent, 0.0, values)


def acceleration(
    dynamics: Dynamics,
    q: FloatArray,
    qd: FloatArray,
    forces: FloatArray,
    w_e: FloatArray | None = None,
) -> FloatArray:
    """Compute qdd = -M⁻¹ (L'f + C + G + D qd + w_e), shape (n,), in [rad/s²] or [m/s²].

    Args:
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        forces: f, shape (a,), in [N] and [N·m].
        w_e: Generalised external load, shape (n,), in [N·m] or [N], or None.
    """
    torque = dynamics.actuator_jacobian(q).T @ forces + bias_torque(dynamics, q, qd)
    if w_e is not None:
        torque = torque + w_e
    qdd = -np.asarray(np.linalg.solve(dynamics.mass_matrix(q), torque), dtype=np.float64)
    complete = getattr(dynamics, "complete", None)  # only robots with loops have this method
    return qdd if complete is None else np.asarray(complete(q, qd, qdd))
