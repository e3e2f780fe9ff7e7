"""Mass properties from Fusion, in SI units."""

from __future__ import annotations

from typing import Any, Literal

import adsk.fusion

from ...snapshot import MassSnapshot
from ..units import KG_CM2, finite, position

Accuracy = Literal["high", "very_high"]
"""How well Fusion weighs: to about a ten-thousandth, or better, which takes it longer."""


def read_mass(owner: Any, accuracy: Accuracy = "very_high") -> MassSnapshot | None:
    """Return the mass properties of a body or an occurrence, in the root frame.

    Fusion's default accuracy is some per cent off. The products of inertia are entries of the
    matrix.

    Args:
        owner: A proxy, or an entity of the root component.
        accuracy: How well it is weighed.

    Returns:
        None if it has no mass.

    Raises:
        ValueError: Fusion could not calculate them.
    """
    levels = adsk.fusion.CalculationAccuracy
    properties = owner.getPhysicalProperties(
        levels.HighCalculationAccuracy if accuracy == "high" else levels.VeryHighCalculationAccuracy
    )
    if properties is None:
        raise ValueError("Fusion gives none")
    mass = finite(properties.mass)
    if mass < 0.0:
        raise ValueError(f"Fusion gives a mass of {mass} kg")
    if mass == 0.0:
        return None
    xx, yy, zz, xy, yz, xz = _inertias(properties.getXYZMomentsOfInertia(), 6)
    a, b, c = _inertias(properties.getPrincipalMomentsOfInertia(), 3)
    return MassSnapshot(
        mass, position(properties.centerOfMass), (xx, yy, zz, xy, yz, xz), (a, b, c)
    )


def _inertias(returned: Any, count: int) -> tuple[float, ...]:
    """Moments of inertia, in [kg·m²], of a call that also returns whether it worked."""
    done, *values = returned
    if not done or len(values) != count:
        raise ValueError("Fusion could not calculate the moments of inertia")
    return tuple(finite(value) * KG_CM2 for value in values)
