"""Stiffness of a joint configuration that muscles hold with given forces.

With tau = -L(q)'f from the muscles and loads G(q), a small displacement dq from equilibrium meets
the torque -K dq with

    K = K_g + K_c + K_l,   K_g = d(L'f)/dq at held f = sum_i f_i d²l_i/dq²,
                           K_c = L' diag(k) L,   K_l = dG/dq.

K_g, from pretension, may well be negative: pretension then destabilises what muscles of finite
stiffness, or a controller, must hold. Behzadipour, Khajepour, "Stiffness of cable-based parallel
manipulators with application to stability analysis", J. Mechanical Design 128 (2006).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, SimulationError
from controllers.arrays import FloatArray
from controllers.dynamics import Dynamics, TaskDynamics
from controllers.validation import finite_vector, is_finite, named_vector

STEP = 1e-3
"""Step of the differences, in [rad] or [m].

They are central and of fourth order: their error is about h⁴/30 of the fifth derivative, and eps/h
from rounding. For paths of some 0.1 to 1 m these meet near eps^(1/5) = 7e-4; at 1e-3 both are some
1e-13 of L.
"""

_SOFT = 1e-9  # an eigenvalue below this part of the largest is zero


@dataclass(frozen=True, eq=False)
class Stiffness:
    """Stiffness in joint coordinates, in [N·m/rad] or alike, shape (n, n) each, symmetric.

    Attributes:
        geometric: K_g, from the held forces.
        cable: K_c, from the muscles' own stiffness; zero if they hold their force exactly.
        load: K_l, from gravity.
        asymmetry: Largest difference of K_g from its transpose before it was made symmetric: it is
            a second derivative, so this is the error of the differences.
        coordinate_names: n names.
    """

    geometric: FloatArray
    cable: FloatArray
    load: FloatArray
    asymmetry: float
    coordinate_names: tuple[str, ...]

    @property
    def total(self) -> FloatArray:
        """K = K_g + K_c + K_l."""
        return self.geometric + self.cable + self.load

    @property
    def is_stable(self) -> bool:
        """Whether every displacement is pulled back: K is positive definite."""
        values = np.linalg.eigvalsh(self.total)
        return bool(values[0] > _SOFT * np.abs(values).max())

    def warnings(self) -> list[str]:
        """Warnings about stiffness by pretension; empty if there are none."""
        found = []
        values, directions = np.linalg.eigh(self.geometric)
        if values[0] < -_SOFT * np.abs(values).max():
            found.append(
                f"the held forces destabilise: geometric stiffness {values[0]:.4g} along "
                f"{self._along(directions[:, 0])}; more pretension makes it worse"
            )
        if not self.is_stable:
            values, directions = np.linalg.eigh(self.total)
            found.append(
                f"the configuration is not stable by itself: stiffness {values[0]:.4g} along "
                f"{self._along(directions[:, 0])}"
            )
        return found

    def rates(self, M: ArrayLike) -> FloatArray:
        """Eigenvalues of -M⁻¹K, smallest first, shape (n,), in [1/s²].

        A positive one, at held forces, is what a position gain Kp must exceed: a displacement grows
        as exp(sqrt(rate) t).

        Args:
            M: Mass matrix, shape (n, n).
        """
        C = np.linalg.cholesky(np.asarray(M, dtype=np.float64))
        half = np.linalg.solve(C, self.total)
        rates: FloatArray = np.linalg.eigvalsh(-np.linalg.solve(C, half.T))
        return rates

    def compliance(self, J: ArrayLike) -> FloatArray:
        """Displacement of a task for forces on it, J K⁻¹ J', shape (k, k), in [m/N] or alike.

        Args:
            J: Task Jacobian, shape (k, n).

        Raises:
            InputError: J has another shape.
            SimulationError: K is singular, or not stable: there is no equilibrium to deviate from.
        """
        J_ = np.asarray(J, dtype=np.float64)
        n = len(self.coordinate_names)
        if J_.ndim != 2 or J_.shape[1] != n:
            raise InputError(f"J must have shape (k, {n}), not {J_.shape}")
        if not self.is_stable:
            raise SimulationError(f"no compliance: {self.warnings()[-1]}")
        compliance: FloatArray = J_ @ np.linalg.solve(self.total, J_.T)
        return 0.5 * (compliance + compliance.T)

    def task_stiffness(self, J: ArrayLike) -> FloatArray:
        """Inverse of the compliance, shape (k, k), in [N/m] or alike: other tasks move freely.

        Args:
            J: Task Jacobian, shape (k, n).

        Raises:
            InputError: J has another shape, or its rows depend on each other.
            SimulationError: The configuration is not stable.
        """
        compliance = self.compliance(J)
        values = np.linalg.eigvalsh(compliance)
        if values[0] <= _SOFT * values[-1]:
            raise InputError(
                "the task coordinates depend on each other; their stiffness does not exist"
            )
        return np.asarray(np.linalg.inv(compliance), dtype=np.float64)

    def _along(self, direction: FloatArray) -> str:
        names = zip(self.coordinate_names, direction, strict=True)
        return ", ".join(f"{value:+.2f} {name}" for name, value in names if abs(value) > 0.01)


def stiffness(
    dynamics: Dynamics,
    q: ArrayLike,
    forces: ArrayLike,
    *,
    muscle_stiffness: ArrayLike = 0.0,
    step: float = STEP,
) -> Stiffness:
    """Stiffness at a configuration, from L and its differences.

    Args:
        dynamics: The robot.
        q: Joint positions, shape (n,), in [rad] or [m].
        forces: f, shape (m,), in [N].
        muscle_stiffness: k, a number or shape (m,), in [N/m]; 0 for muscles whose force is held.
        step: Step of the differences, in [rad] or [m].

    Raises:
        InputError: A size or a number is wrong.
    """
    q_ = finite_vector("q", q, len(dynamics.coordinate_names))
    f = finite_vector("forces", forces, len(dynamics.muscle_names))
    k = named_vector("muscle_stiffness", muscle_stiffness, dynamics.muscle_names)
    if not (is_finite(step) and step > 0):
        raise InputError(f"step must be finite and positive: {step}")
    K_g = _jacobian(lambda x: dynamics.muscle_jacobian(x).T @ f, q_, step)
    K_l = _jacobian(dynamics.gravity, q_, step)
    half = np.sqrt(k)[:, None] * dynamics.muscle_jacobian(q_)
    return Stiffness(
        0.5 * (K_g + K_g.T),
        half.T @ half,
        0.5 * (K_l + K_l.T),
        float(np.abs(K_g - K_g.T).max(initial=0.0)),
        dynamics.coordinate_names,
    )


def task_stiffness(
    dynamics: TaskDynamics, q: ArrayLike, forces: ArrayLike, muscle_stiffness: ArrayLike
) -> FloatArray:
    """Stiffness of the task coordinates of a robot that muscles hold, shape (k, k).

    Args:
        dynamics: The robot.
        q: Joint positions, shape (n,), in [rad] or [m].
        forces: f, shape (m,), in [N].
        muscle_stiffness: k, a number or shape (m,), in [N/m].

    Raises:
        InputError: A size or a number is wrong, or the task coordinates depend on each other.
        SimulationError: The configuration is not stable.
    """
    joint = stiffness(dynamics, q, forces, muscle_stiffness=muscle_stiffness)
    return joint.task_stiffness(dynamics.task_jacobian(np.asarray(q, dtype=np.float64)))


def _jacobian(function: Callable[[FloatArray], FloatArray], q: FloatArray, h: float) -> FloatArray:
    """Derivative by central differences of fourth order, shape (n, n)."""
    columns = []
    for j in range(len(q)):
        e = np.zeros(len(q))
        e[j] = h
        near = function(q + e) - function(q - e)
        far = function(q + 2.0 * e) - function(q - 2.0 * e)
        columns.append((8.0 * near - far) / (12.0 * h))
    return np.array(columns).T
