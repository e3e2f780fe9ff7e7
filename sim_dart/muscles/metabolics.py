"""Metabolic rates of muscles by Umberger 2010 and Bhargava 2004, as in OpenSim's probes.

The rate of a muscle is the sum of its heat rates and the mechanical power of its active fibres.
Rates do not include the basal rate of the body. The total of a muscle is not negative, and its heat
rate is at least 1 W/kg. Fibre velocities are positive while a muscle lengthens.

* Umberger 2010, J. R. Soc. Interface 7, after Umberger, Gerritsen & Martin 2003, Comput. Methods
  Biomech. Biomed. Engin. 6: heat of activation and maintenance, and of shortening or lengthening.
* Bhargava, Pandy & Anderson 2004, J. Biomech. 37: heat of activation, maintenance, and shortening.

Both use the recruitment of slow and fast fibres of Bhargava et al.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sim_dart.core.arrays import FloatArray

SPECIFIC_TENSION = 0.25e6
"""Force per area of a muscle, in [N/m²]."""
DENSITY = 1059.7
"""Density of muscles, in [kg/m³]."""
_AEROBIC = 1.5
_MIN_HEAT = 1.0  # in [W/kg]
_MAX_SHORTENING_HEAT = 100.0  # of slow fibres, in [W/kg]
_SLOW_SPEED = 2.5  # maximum velocity of fast over slow fibres
_MAINTENANCE = (0.0, 0.5, 1.0, 1.5, 2.0), (0.5, 0.5, 1.0, 0.0, 0.0)
"""Maintenance heat over normalised fibre length: lengths and factors."""


class FibreStates(NamedTuple):
    """States of muscles; all arrays can be broadcast, with one column for each of m muscles.

    Attributes:
        force: Maximum isometric forces, in [N].
        optimal: Optimal fibre lengths, in [m].
        speed: Maximum contraction velocities, in optimal fibre lengths per second.
        excitation, activation: From 0 to 1.
        length: Fibre lengths over optimal fibre lengths.
        velocity: Fibre velocities, in [m/s].
        active_length: Factors of the active force-length curve.
        active: Active fibre forces, in [N].
        passive: Passive fibre forces with damping, in [N].
        slow: Fractions of slow fibres.
    """

    force: FloatArray
    optimal: FloatArray
    speed: FloatArray
    excitation: FloatArray
    activation: FloatArray
    length: FloatArray
    velocity: FloatArray
    active_length: FloatArray
    active: FloatArray
    passive: FloatArray
    slow: FloatArray | float = 0.5

    @property
    def mass(self) -> FloatArray:
        """Masses of the muscles, in [kg]."""
        return self.force / SPECIFIC_TENSION * DENSITY * self.optimal

    @property
    def recruited(self) -> tuple[FloatArray, FloatArray]:
        """Recruited fractions of slow and fast fibres."""
        angle = 0.5 * np.pi * self.excitation
        return self.slow * np.sin(angle), (1.0 - self.slow) * (1.0 - np.cos(angle))


def umberger_2010(state: FibreStates) -> FloatArray:
    """Return the metabolic rates of muscles, in [W]."""
    u_slow, u_fast = state.recruited
    idle = state.excitation == 0.0
    slow = np.where(idle, 1.0, u_slow / np.where(idle, 1.0, u_slow + u_fast))
    mean = 0.5 * (state.excitation + state.activation)
    A = np.where(state.excitation > state.activation, state.excitation, mean)
    is_long = state.length > 1.0
    heat = 128.0 * (1.0 - slow) + 25.0
    heat = np.where(is_long, 0.4 * heat + 0.6 * heat * state.active_length, heat)
    maintenance = _AEROBIC * A**0.6 * heat
    v = state.velocity / state.optimal
    of_slow, of_fast = 100.0 * _SLOW_SPEED / state.speed, 153.0 / state.speed
    shortening = np.minimum(-of_slow * v, _MAX_SHORTENING_HEAT) * slow - of_fast * v * (1.0 - slow)
    moving = np.where(v <= 0.0, A**2 * shortening, 4.0 * A * of_slow * v)
    moving = _AEROBIC * np.where(is_long, moving * state.active_length, moving)
    power = -np.maximum(state.active, 0.0) * state.velocity / state.mass
    return _total(maintenance + moving, power) * state.mass


def bhargava_2004(state: FibreStates) -> FloatArray:
    """Return the metabolic rates of muscles, in [W]."""
    u_slow, u_fast = state.recruited
    factor = np.interp(state.length, *_MAINTENANCE)
    activation = 40.0 * u_slow + 133.0 * u_fast
    maintenance = factor * (74.0 * u_slow + 111.0 * u_fast)
    total = state.active + state.passive
    shortening = np.where(state.velocity <= 0.0, -0.25 * total * state.velocity, 0.0) / state.mass
    power = -state.active * state.velocity / state.mass
    return _total(activation + maintenance + shortening, power) * state.mass


def _total(heat: FloatArray, power: FloatArray) -> FloatArray:
    """Return heat rate and power with the lower limits of both, in [W/kg]."""
    heat = heat + np.maximum(-(heat + power), 0.0)
    return np.asarray(np.maximum(heat, _MIN_HEAT) + power)
