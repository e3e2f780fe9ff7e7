"""Energy balance of a plant: its energies and the work done on it.

Kinetic plus potential energy minus the work of muscles, external forces and damping is constant,
except for dissipation by joint stops, friction and contacts, and for integration errors.
"""

from __future__ import annotations

from typing import NamedTuple


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
