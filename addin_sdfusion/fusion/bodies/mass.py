"""Mass properties from Fusion, in SI units."""

from __future__ import annotations

from typing import Any, Literal

import adsk.fusion

from ...snapshot import MassSnapshot
from ..units import KG_CM2, finite, position

Accuracy = Literal["high", "very_high"]
"""Accuracy of Fusion's mass properties: about 1e-4, or better but slower."""


def read_mass(owner: Any, accuracy: Accuracy = "very_high") -> MassSnapshot | None:
    """Return the mass properties of a body or an occurrence, in the root frame.

    Fusion's default accuracy has errors of several per cent. The products of inertia are entries
    of the inertia matrix.

    Args:
        owner: A proxy, or an entity of the root component.
        accuracy: Accuracy of the calculation.

    Returns:
        The mass properties; None for an owner without mass.

    Raises:
        ValueError: Fusion could not calculate the mass properties.
    """
    levels = adsk.fusion.CalculationAccuracy
    properties = owner.getPhysicalProperties(
        levels.HighCalculationAccuracy if accuracy == "high" else levels.VeryHighCalculationAccuracy
    )
    if properties is None:
        raise ValueError("Fusion returned no mass properties")
    mass = finite(properties.mass)
    if mass < 0.0:
        raise ValueError(f"Fusion returned a mass of {mass} kg")
    if mass == 0.0:
        return None
    xx, yy, zz, xy, yz, xz = _inertias(properties.getXYZMomentsOfInertia(), 6)
    a, b, c = _inertias(properties.getPrincipalMomentsOfInertia(), 3)
    return MassSnapshot(
        mass, position(properties.centerOfMass), (xx, yy, zz, xy, yz, xz), (a, b, c)
    )


def _inertias(returned: Any, count: int) -> tuple[float, ...]:
    """Return moments of inertia, in [kg·m²], from a result that starts with a success flag."""
    done, *values = returned
    if not done or len(values) != count:
        raise ValueError("Fusion could not calculate the moments of inertia")
    return tuple(finite(value) * KG_CM2 for value in values)
