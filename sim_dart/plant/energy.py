"""Energy balance of a plant: its energies and momenta, and the work done on it.

kinetic + potential - work of muscles - of external forces - of damping is constant, apart from what
joint stops, friction and contacts dissipate, and from the integrator's error.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray

from .dart_mechanism import DartMechanism


class Energy(NamedTuple):
    """Energies of a robot and the work done on it since the reset, in [J].

    Attributes:
        kinetic: 1/2 qd'M qd.
        potential: Of its weight, zero at the world's origin, and of its joints' springs.
        muscle_work: Of the muscles, the energy that they and presliding cables store included.
        outer_work: Of motors of joints and of loads.
        damping_work: Of the joints' damping; never positive.
        friction_work: Of the friction of cables; never positive.
    """

    kinetic: float
    potential: float
    muscle_work: float
    outer_work: float
    damping_work: float
    friction_work: float


class EnergyBalance:
    """Work done on a robot, summed over steps.

    Args:
        robot: The robot.

    Attributes:
        work: Of muscles, of external forces, of damping, of cables' friction, shape (4,), in [J].
    """

    def __init__(self, robot: Robot) -> None:
        self.work = np.zeros(4)
        self._damping = np.array([c.damping for c in robot.coordinates])

    def add_step(self, h: float, mechanism: DartMechanism, loaded: bool, qd: FloatArray) -> None:
        """Add the work of a semi-implicit step: forces of its beginning, mean of its velocities.

        With a constant mass matrix that is the step's change of the kinetic energy, exactly.

        Args:
            h: Length of the step, in [s].
            mechanism: The robot at the step's beginning, its forces evaluated.
            loaded: Whether external forces act.
            qd: Velocities at the step's end, shape (n,).
        """
        mean = 0.5 * (mechanism.qd + qd)
        outer = mechanism.outer_torques @ mean if loaded else 0.0
        powers = (mechanism.muscle_torques @ mean, outer, -(self._damping * qd) @ mean)
        self.work[:3] += h * np.array(powers)
