"""Mass properties from Fusion at its highest accuracy, in SI units."""

from __future__ import annotations

from typing import Any

import adsk.fusion

from ...snapshot import MassSnapshot
from ..units import KG_CM2, finite, position


def read_mass(owner: Any) -> MassSnapshot | None:
    """The mass properties of a body or an occurrence, in the root frame.

    The default accuracy is some per cent off. The products of inertia are passed on as they
    are: their sign is not documented.

    Args:
        owner: A proxy, or an entity of the root component.

    Returns:
        None if it has no mass.

    Raises:
        ValueError: Fusion could not calculate them.
    """
    accuracy = adsk.fusion.CalculationAccuracy.VeryHighCalculationAccuracy
    properties = owner.getPhysicalProperties(accuracy)
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
