"""PhysicalProperties, exact at the highest accuracy, with known errors below it."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import Base, api, new
from ..maths import point
from ..state import world
from .shapes import Mass

VERY_HIGH = 3
_ERROR = {0: 1e-2, 1: 1e-3, 2: 1e-4, 3: 0.0}


def physical_properties(mass: Mass, accuracy: int, T: np.ndarray) -> Any:
    """Return the API object.

    Args:
        mass: Mass properties in the frame of the component.
        accuracy: A CalculationAccuracy value.
        T: Pose of the component in the context.

    Raises:
        RuntimeError: The accuracy is invalid or the mass is zero.
    """
    if accuracy not in _ERROR:
        raise RuntimeError("3 : invalid argument accuracy")
    error = _ERROR[accuracy]
    blurred = Mass(
        mass.mass * (1.0 + error),
        mass.com * (1.0 - error),
        mass.inertia * (1.0 - error),
        mass.volume * (1.0 + error),
    )
    return new(PhysicalProperties, mass=blurred.moved(T), accuracy=accuracy)


@api("adsk.fusion")
class PhysicalProperties(Base):
    """Physical properties; `_mass` is in the frame of the context."""

    accuracy = property(lambda self: self._accuracy)
    mass = property(lambda self: float(self._mass.mass))
    volume = property(lambda self: float(self._mass.volume))

    @property
    def density(self) -> float:
        return float(self._mass.mass / self._mass.volume) if self._mass.volume else 0.0

    centerOfMass = property(lambda self: point(self._mass.com))

    def getXYZMomentsOfInertia(self) -> tuple:
        """Return moments about the origin of the context: ok, xx, yy, zz, xy, yz, xz [kg·cm²]."""
        inertia = self._mass.about_origin()
        sign = 1.0 if world().options.product_sign == "tensor" else -1.0
        xx, yy, zz = np.diag(inertia).tolist()
        xy, yz, xz = (sign * float(inertia[i, j]) for i, j in ((0, 1), (1, 2), (0, 2)))
        return (True, xx, yy, zz, xy, yz, xz)

    def getPrincipalMomentsOfInertia(self) -> tuple:
        """Return the principal moments about the centre of mass, in [kg·cm²], in any order."""
        return (True, *np.linalg.eigvalsh(self._mass.inertia).tolist())
