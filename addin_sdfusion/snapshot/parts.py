"""Occurrences, bodies and rigid groups of a design."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Annotated, Literal

from ..robot.model.pose import Vector3
from ..robot.records import Form, Samples

ROOT = ""
"""Path of the root component."""

LINK_PREFIX = "EXPORT_"
"""Prefix of the names of rigid groups that are links. In designs of earlier add-ins, names of
components and joints have it too."""

COLOR = re.compile("#[0-9a-fA-F]{6}", re.ASCII)
Color = Annotated[str, Form("#rrggbb", COLOR.pattern)]


def bare_name(name: str) -> str:
    """Return the name of a rigid group, component or joint in the robot."""
    return name.removeprefix(LINK_PREFIX)


@dataclass(frozen=True, slots=True)
class MassSnapshot:
    """Mass properties as reported by the CAD system.

    Attributes:
        mass: In [kg].
        com: Centre of mass, in [m].
        moments: xx, yy, zz, xy, yz, xz about the root frame's origin and axes, in [kg·m²]. The
            products are entries of the inertia matrix, xy = -∫ x y dm. If the principal moments
            show that the CAD system reports their negatives, the export changes the sign.
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
        triangles: Three node indices per triangle, counter-clockwise seen from outside.
    """

    nodes: Annotated[Samples, "d"]
    triangles: Annotated[Samples, "i"]


@dataclass(frozen=True, slots=True)
class BodySnapshot:
    """A body in one occurrence.

    Attributes:
        name: Name of the body.
        occurrence: Path of the occurrence that it belongs to.
        kind: `solid`, `surface` or `mesh`; only a solid has mass.
        visible: Whether it is visible.
        mass: Mass properties; None if not available.
        material: Name of the material; empty if not specified.
        mesh: Triangle mesh; None if not requested.
        color: Colour; None if unknown.
        opacity: Opacity, from 0 (transparent) to 1 (opaque).
        appearance: Name of the appearance; empty if not specified.
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
    """An occurrence of a component.

    Attributes:
        path: Full path, which is unique.
        parent: Path of the parent occurrence.
        component: Name of the component.
        grounded: Whether the user has grounded it, which fixes it to its parent.
        visible: Whether it is visible.
        referenced: Whether the component belongs to another document.
        mass: Mass properties including all occurrences below it and any mass that the user has
            set for the component; None if not available.
        ground_to_parent: Whether it is fixed to its parent, possibly by the CAD system: Fusion
            does this for the first component of a design. Other fixed links of the tree and
            joints take precedence.
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
        """Whether it is fixed to its parent."""
        return self.grounded or self.ground_to_parent


@dataclass(frozen=True, slots=True)
class GroupSnapshot:
    """A rigid group.

    Attributes:
        name: Name of the group.
        occurrences: Paths of its members. An occurrence that is not in a group belongs to the
            group of its nearest ancestor that is in one.
        suppressed: Whether it is suppressed in the timeline.
    """

    name: str
    occurrences: tuple[str, ...]
    suppressed: bool = False
