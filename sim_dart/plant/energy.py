"""Bookkeeping of a plant: its energies and momenta, and the work that was done on it.

kinetic + potential - work of muscles - of what acts from outside - of damping is constant, but for
what stops, friction and contacts take, and for the integrator's error.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray

from .dart_mechanism import DartMechanism
from .mechanism import Mechanism


class Energy(NamedTuple):
    """Energies of a robot and the work done on it since the reset, in [J].

    Attributes:
        kinetic: 1/2 qd'M qd.
        potential: Of its weight, zero at the world's origin, and of its joints' springs.
        muscle_work: Of the muscles; what they store themselves is not told apart.
        outer_work: Of motors of joints and of loads.
        damping_work: Of the joints' damping; never positive.
    """

    kinetic: float
    potential: float
    muscle_work: float
    outer_work: float
    damping_work: float


class Ledger:
    """The books of a robot.

    Args:
        robot: The robot.

    Attributes:
        work: Of muscles, of what acts from outside, of damping, shape (3,), in [J].
    """

    def __init__(self, robot: Robot) -> None:
        self.work = np.zeros(3)
        self._damping = np.array([c.damping for c in robot.coordinates])

    def book(self, h: float, mechanism: DartMechanism, is_held: bool, later: FloatArray) -> None:
        """Book a semi-implicit step: forces as at its beginning, at the mean of its velocities.

        With a constant mass matrix that is what the step does to the kinetic energy, exactly.

        Args:
            h: Length of the step, in [s].
            mechanism: The robot at the step's beginning, its forces evaluated.
            is_held: Whether something acts from outside.
            later: qd at the step's end, shape (n,).
        """
        mean = 0.5 * (mechanism.qd + later)
        outer = mechanism.outer_torques @ mean if is_held else 0.0
        powers = (mechanism.muscle_torques @ mean, outer, -(self._damping * later) @ mean)
        self.work += h * np.array(powers)

    def add(self, work: FloatArray) -> None:
        """Book work that an integrator has summed up, shape (3,), in [J]."""
        self.work += work

    def energy(self, mechanism: Mechanism) -> Energy:
        """The energies at the present state."""
        return Energy(mechanism.kinetic_energy, mechanism.potential_energy, *self.work.tolist())
