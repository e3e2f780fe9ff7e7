"""Mass properties from Fusion, in SI units."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import adsk.fusion

from ...robot.model.transform import IDENTITY, Transform
from ...snapshot import BodySnapshot, MassSnapshot, OccurrenceSnapshot
from ...snapshot.mass_properties import Sign, common_sign, is_usable, moved
from ..notes import optional
from ..occurrences import Occurrence, Occurrences, identity
from ..units import KG_CM2, finite, position

Part = TypeVar("Part", BodySnapshot, OccurrenceSnapshot)


class Weigher:
    """Mass properties of components and their bodies, each calculated once, in their frame.

    Occurrences of a component share its mass if the components in them have equal poses.

    Attributes:
        frames: Pose of the frame of the mass properties of each occurrence in the root frame.
    """

    def __init__(self, occurrences: Occurrences) -> None:
        """Create a weigher."""
        self.frames: dict[str, Transform] = {}
        self._occurrences = occurrences
        self._children: dict[str, list[Occurrence]] = {}
        for occurrence in occurrences.values():
            if occurrence.path:
                self._children.setdefault(occurrence.parent, []).append(occurrence)
        self._firsts: dict[Hashable, Occurrence] = {}
        self._components: list[Any] = []
        self._numbers: dict[Hashable, list[int]] = {}
        self._masses: dict[Hashable, tuple[Any, MassSnapshot | None]] = {}

    def occurrence(self, occurrence: Occurrence) -> MassSnapshot | None:
        """Return the mass properties of an occurrence with its contents; raises as `read_mass`.

        They are in a frame whose pose is in `frames`. A component that contains others may differ
        between occurrences, so the first occurrence with equal contents is weighed.
        """
        key = self._contents(occurrence)
        self.frames[occurrence.path] = occurrence.T
        if occurrence.path not in self._children:
            return self._once(key, occurrence.component)
        first = self._firsts.setdefault(key, occurrence)
        is_first = first is occurrence
        self.frames[occurrence.path] = (
            IDENTITY if is_first else occurrence.T.compose(first.T.inverse())
        )
        return self._once(key, first.native)

    def body(self, body: Any, name: str, occurrence: Occurrence) -> MassSnapshot | None:
        """Return the mass properties of a body of a component; raises as `read_mass`.

        A body that is alone in its component has the mass of the component.
        """
        if occurrence.path and self._is_alone(occurrence):
            return self.occurrence(occurrence)
        return self._once((self._number(occurrence), name), body)

    def _is_alone(self, occurrence: Occurrence) -> bool:
        """Return whether a component consists of one solid body."""
        component = occurrence.component
        count = optional(lambda: int(component.bRepBodies.count + component.meshBodies.count))
        return count == 1 and occurrence.path not in self._children

    def _once(self, key: Hashable, owner: Any) -> MassSnapshot | None:
        if key not in self._masses or self._masses[key][0] != owner:
            self._masses[key] = owner, read_mass(owner)
        return self._masses[key][1]

    def _contents(self, occurrence: Occurrence) -> Hashable:
        """Return a key that is equal for occurrences with equal contents."""
        inverse = occurrence.T.inverse()
        children = self._children.get(occurrence.path, ())
        inner = [(_rounded(inverse.compose(c.T)), self._contents(c)) for c in children]
        return self._number(occurrence), tuple(inner)

    def _number(self, occurrence: Occurrence) -> int:
        """Return a number that is equal for occurrences of the same component only.

        Copies of a document contain different components with equal ids.
        """
        component = occurrence.component
        numbers = self._numbers.setdefault(identity(occurrence), [])
        for number in numbers:
            if self._components[number] == component:
                return number
        self._components.append(component)
        numbers.append(len(self._components) - 1)
        return numbers[-1]

    def in_root_frame(
        self, parts: Sequence[OccurrenceSnapshot], bodies: Sequence[BodySnapshot]
    ) -> tuple[list[OccurrenceSnapshot], list[BodySnapshot]]:
        """Return occurrences and bodies with masses in the root frame."""
        masses = [*(part.mass for part in parts), *(body.mass for body in bodies)]
        sign = common_sign(mass for mass in masses if mass is not None and is_usable(mass))
        return (
            [_placed(o, self.frames.get(o.path, IDENTITY), sign) for o in parts],
            [_placed(b, self._occurrences[b.occurrence].T, sign) for b in bodies],
        )


def _rounded(T: Transform) -> Hashable:
    return tuple(round(x, 9) + 0.0 for row in (*T.R, T.p) for x in row)


def _placed(part: Part, T: Transform, sign: Sign) -> Part:
    return part if part.mass is None else replace(part, mass=moved(part.mass, T, sign))


def read_mass(owner: Any) -> MassSnapshot | None:
    """Return the mass properties of a body or a component, in the frame of the component.

    Fusion's default accuracy has errors of several per cent. The products of inertia are entries
    of the inertia matrix.

    Returns:
        The mass properties; None for an owner without mass.

    Raises:
        ValueError: Fusion could not calculate the mass properties.
    """
    levels = adsk.fusion.CalculationAccuracy
    properties = owner.getPhysicalProperties(levels.VeryHighCalculationAccuracy)
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
