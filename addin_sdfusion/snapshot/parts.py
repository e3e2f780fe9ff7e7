"""Occurrences, bodies and rigid groups of a design."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Annotated, Literal

from ..records import Form, Samples
from ..robot.model.pose import Vector3

ROOT = ""
"""Path of the root component."""

LINK_PREFIX = "EXPORT_"
"""How the names of rigid groups that are links begin; also of components and joints, as in designs
of earlier add-ins."""

COLOR = re.compile("#[0-9a-fA-F]{6}", re.ASCII)
Color = Annotated[str, Form("#rrggbb", COLOR.pattern)]


def bare_name(name: str) -> str:
    """What a robot calls a rigid group, component or joint."""
    return name.removeprefix(LINK_PREFIX)


@dataclass(frozen=True, slots=True)
class MassSnapshot:
    """Mass properties as the CAD system gives them.

    Attributes:
        mass: In [kg].
        com: Centre of mass, in [m].
        moments: xx, yy, zz, xy, yz, xz about the root frame's origin and axes, in [kg·m²]. The
            products are entries of the inertia matrix, xy = -∫ x y dm; where the principal moments
            say that a CAD system gives their negatives, they are taken so.
        principal: Principal moments about the centre of mass, in [kg·m²], in any order.
    """

    mass: float
    com: Vector3
    moments: tuple[float, float, float, float, float, float]
    principal: Vector3


@dataclass(frozen=True, slots=True)
class MeshSnapshot:
    """Triangles of a body.

    Attributes:
        nodes: x, y, z of every node, in [m].
        triangles: Three indices of nodes for every triangle, counter-clockwise seen from outside.
    """

    nodes: Annotated[Samples, "d"]
    triangles: Annotated[Samples, "i"]


@dataclass(frozen=True, slots=True)
class BodySnapshot:
    """A body in one place.

    Attributes:
        name: Its name.
        occurrence: Path of the occurrence that it belongs to.
        kind: `solid`, `surface` or `mesh`; a solid alone has mass.
        visible: Whether it is shown.
        mass: Mass properties; None if there are none.
        material: Name of its material; empty if it has none.
        mesh: Its triangles; None if they were not asked for.
        color: Its colour; None if the CAD system does not say.
        opacity: From 0, not seen, to 1.
        appearance: Name of its appearance, where the CAD system has such; empty if not.
    """

    name: str
    occurrence: str
    kind: Literal["solid", "surface", "mesh"] = "solid"
    visible: bool = True
    mass: MassSnapshot | None = None
    material: str = ""
    mesh: MeshSnapshot | None = None
    color: Color | None = None
    opacity: float = 1.0
    appearance: str = ""


@dataclass(frozen=True, slots=True)
class OccurrenceSnapshot:
    """A component in one place.

    Attributes:
        path: Its full path; unique.
        parent: Path of the occurrence that holds it.
        component: Name of its component.
        grounded: Whether the user has fixed it to the occurrence, or the root, that holds it.
        visible: Whether it is shown.
        referenced: Whether the component lives in another document.
        mass: Mass properties with everything below it, which honour a mass that the user has set
            for the component; None if there are none.
        ground_to_parent: Whether it is fixed likewise, perhaps by the CAD system itself, as Fusion
            does to a design's first component: it yields to others of its tree that are fixed.
    """

    path: str
    parent: str
    component: str
    grounded: bool = False
    visible: bool = True
    referenced: bool = False
    mass: MassSnapshot | None = None
    ground_to_parent: bool = False

    @property
    def is_fixed(self) -> bool:
        """Whether it is fixed to what holds it."""
        return self.grounded or self.ground_to_parent


@dataclass(frozen=True, slots=True)
class GroupSnapshot:
    """A rigid group.

    Attributes:
        name: Its name.
        occurrences: Paths of its members. An occurrence that is in no group goes with the nearest
            one above it that is.
        suppressed: Whether it is switched off in the timeline.
    """

    name: str
    occurrences: tuple[str, ...]
    suppressed: bool = False
