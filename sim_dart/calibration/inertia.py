"""Inertial parameters of a body, and a prior for physically consistent values.

The ten parameters are mass, first moments and inertia; dynamics are linear in them. They are
physically consistent if the 4 x 4 pseudo-inertia P = int [x; 1] [x; 1]' dm is positive definite
(Wensing, Kim & Slotine 2018, IEEE Robotics and Automation Letters 3).
"""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot.model.robot import Inertia
from sim_dart.core.arrays import FloatArray

NUMBERS = {
    "mass": "kg",
    **dict.fromkeys(("moment_x", "moment_y", "moment_z"), "kg.m"),
    **dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), "kg.m2"),
}
"""Names of the numbers of `inertia_numbers` with their units, in order."""

_THIN = 0.1
_MIN_RADIUS = 1e-3


def inertia_numbers(inertia: Inertia) -> FloatArray:
    """Return mass, first moments and inertia about the link origin, shape (10,), in SI units."""
    at_origin = Inertia.of(inertia.mass, inertia.com, inertia.about((0.0, 0.0, 0.0)))
    moments = (inertia.mass * x for x in inertia.com)
    return np.array([inertia.mass, *moments, *at_origin.entries])


def inertia_of(numbers: FloatArray) -> Inertia:
    """Return the inertia for given numbers, the inverse of `inertia_numbers`."""
    x, y, z = (numbers[1:4] / numbers[0]).tolist()
    return Inertia.of_origin(float(numbers[0]), (x, y, z), _matrix(numbers).tolist())


def thicken(inertia: Inertia) -> FloatArray:
    """Return the numbers of a body, with a minimum thickness so that they are consistent."""
    I = np.array(inertia.matrix)  # noqa: E741
    radius = max(float(np.sqrt(max(np.trace(I), 0.0) / 2.0 / inertia.mass)), _MIN_RADIUS)
    values, axes = np.linalg.eigh(np.trace(I) / 2.0 * np.eye(3) - I)
    least = inertia.mass * (_THIN * radius) ** 2
    S = axes @ np.diag(np.maximum(values, least)) @ axes.T
    I = np.trace(S) * np.eye(3) - S  # noqa: E741
    return inertia_numbers(Inertia.of(inertia.mass, inertia.com, I.tolist()))


def pseudo_inertia(numbers: FloatArray) -> FloatArray:
    """Return the pseudo-inertia P, shape (4, 4), which is linear in the numbers."""
    I = _matrix(numbers)  # noqa: E741
    P = np.empty((4, 4))
    P[:3, :3] = np.trace(I) / 2.0 * np.eye(3) - I
    P[:3, 3] = P[3, :3] = numbers[1:4]
    P[3, 3] = numbers[0]
    return P


def _matrix(numbers: FloatArray) -> FloatArray:
    xx, yy, zz, xy, xz, yz = numbers[4:]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


class InertiaPrior:
    """Prior cost of the inertial parameters of a body, infinite for inconsistent values.

    The cost w (log |P0| - log |P| + tr(P0^-1 P) - 4) is convex in the numbers (Lee, Wensing & Park
    2020, IEEE Transactions on Robotics 36). The weight w corresponds to a relative standard
    deviation `sd` of the density, a common factor of all numbers. The standard deviation of the
    mass with other numbers constant is twice as large.

    Args:
        numbers: Prior mean, of a body that is not thin, shape (10,).
        sd: Relative standard deviation of the density.
    """

    def __init__(self, numbers: FloatArray, sd: float) -> None:
        self._mean = numbers
        self._E = np.array([pseudo_inertia(e) for e in np.eye(10)])
        P0 = pseudo_inertia(numbers)
        self._inverse = np.linalg.inv(P0)
        self._logdet = np.linalg.slogdet(P0)[1]
        self._w = 1.0 / (2.0 * sd**2)

    def __call__(self, change: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return the cost of a change of the numbers, half its gradient, and half its Hessian."""
        P, E, w = pseudo_inertia(self._mean + change), self._E, self._w
        if np.linalg.eigvalsh(P)[0] <= 0.0:
            return np.inf, np.zeros(10), np.zeros((10, 10))
        trace = float(np.sum(self._inverse * P))
        cost = w * (self._logdet - np.linalg.slogdet(P)[1] + trace - 4.0)
        PE = np.linalg.solve(P, E)
        g = w / 2.0 * np.trace(self._inverse @ E - PE, axis1=1, axis2=2)
        H = w / 2.0 * np.einsum("iab,jba->ij", PE, PE)
        return float(cost), g, H

    @property
    def sd(self) -> FloatArray:
        """Standard deviations of the numbers, shape (10,)."""
        return np.sqrt(np.diag(np.linalg.inv(self(np.zeros(10))[2])))
