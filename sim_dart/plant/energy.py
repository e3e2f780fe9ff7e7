"""Energy balance of a plant: its energies and the work done on it.

Kinetic plus potential energy minus the work of muscles, external forces and damping is constant,
except for dissipation by joint stops, friction and contacts, and for integration errors.
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
        kinetic: Kinetic energy 1/2 qd'M qd.
        potential: Potential energy of the weight, zero at the world origin, and of joint springs.
        muscle_work: Work of the muscles. It includes energy stored in muscles and in cables that
            do not slip yet.
        outer_work: Work of joint motors, loads and wrenches.
        damping_work: Work of joint damping; never positive.
        friction_work: Work of cable friction; never positive.
    """

    kinetic: float
    potential: float
    muscle_work: float
    outer_work: float
    damping_work: float
    friction_work: float


class EnergyBalance:
    """Sum of the work done on a robot over all steps.

    Attributes:
        work: Work of muscles, external forces, damping and cable friction, shape (4,), in [J].
    """

    def __init__(self, robot: Robot) -> None:
        self.work = np.zeros(4)
        self._damping = np.array([c.damping for c in robot.coordinates])

    def add_step(self, h: float, mechanism: DartMechanism, loaded: bool, qd: FloatArray) -> None:
        """Add the work of a semi-implicit Euler step.

        The work is computed from the forces at the beginning of the step and the mean of both
        velocities. With a constant mass matrix it equals the change of the kinetic energy.

        Args:
            h: Length of the step, in [s].
            mechanism: The mechanism at the beginning of the step, with evaluated forces.
            loaded: Whether external forces act.
            qd: Velocities at the end of the step, shape (n,).
        """
        mean = 0.5 * (mechanism.qd + qd)
        outer = mechanism.outer_torques @ mean if loaded else 0.0
        powers = (mechanism.muscle_torques @ mean, outer, -(self._damping * qd) @ mean)
        self.work[:3] += h * np.array(powers)
