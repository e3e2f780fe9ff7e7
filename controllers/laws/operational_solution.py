"""Posture and solution of controllers in operational space."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from controllers.arrays import FloatArray
from controllers.force_distribution.solution import ForceSolution


@dataclass(frozen=True)
class Posture:
    """Desired motion in the null space of the tasks: qdd_p = kp (q0 - q) - kd qd.

    Attributes:
        kd: Damping, a number or shape (n,), in [1/s].
        kp: Stiffness, a number or shape (n,), in [1/s²].
        q0: The preferred posture, shape (n,), in [rad] or [m]; needed where kp is not 0.
    """

    kd: ArrayLike = 10.0
    kp: ArrayLike = 0.0
    q0: ArrayLike | None = None


DAMPED = Posture()
"""Default posture: self-motion is damped, without a preferred configuration."""


@dataclass(frozen=True)
class OperationalSpaceSolution(ForceSolution):
    """Muscle forces and accelerations; slack is counted in task accelerations.

    Attributes:
        slack: Task acceleration that is missing, shape (k,), in [m/s²] or [rad/s²].
        coordinate_names: Names of the k task coordinates.
        qdd: Acceleration that the forces make by the controller's model, shape (n,).
        limits_dropped: Whether no forces could keep the joint limits' bounds on qdd.
    """

    qdd: FloatArray
    limits_dropped: bool
