"""Snapshot of a design as plain records: all that the export needs of Fusion, in one file.

SI units. Positions and directions are given in the design's root frame, at the
design's pose. An occurrence is named by its full path, such as `arm:1+hand:1`; the root component
has the empty path.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

from .records import Samples, from_plain, to_plain
from .robot.errors import InputError
from .robot.files import read_file, write_files
from .robot.finding import Finding
from .robot.json_text import json_text
from .robot.model.pose import Vector3
from .settings import ExportSettings

FORMAT = 1
"""Version of the file format; a file of another version is refused."""

ROOT = ""
"""Path of the root component."""

_LARGEST = 2**30

JointKind = Literal[
    "rigid", "revolute", "slider", "cylindrical", "pin_slot", "planar", "ball", "inferred"
]
DesignIntent = Literal["part", "assembly", "hybrid", "unknown"]


@dataclass(frozen=True, slots=True)
class MassSnapshot:
    """Mass properties as the CAD system gives them.

    Attributes:
        mass: In [kg].
        com: Centre of mass, in [m].
        moments: xx, yy, zz, xy, yz, xz about the root frame's origin and axes, in [kg·m²]. The
            sign of the products is not documented: see `building.mass_properties`.
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
        mass: Mass properties; None where there are none.
        material: Name of its material; empty if it has none.
        mesh: Its triangles; None where they were not asked for.
    """

    name: str
    occurrence: str
    kind: Literal["solid", "surface", "mesh"] = "solid"
    visible: bool = True
    mass: MassSnapshot | None = None
    material: str = ""
    mesh: MeshSnapshot | None = None


@dataclass(frozen=True, slots=True)
class OccurrenceSnapshot:
    """A component in one place.

    Attributes:
        path: Its full path; unique.
        parent: Path of the occurrence that holds it.
        component: Name of its component.
        grounded: Whether it is fixed to the occurrence, or the root, that holds it.
        visible: Whether it is shown.
        referenced: Whether the component lives in another document.
        mass: Mass properties with everything below it, which honour a mass that the user has set
            for the component; None where there are none.
    """

    path: str
    parent: str
    component: str
    grounded: bool = False
    visible: bool = True
    referenced: bool = False
    mass: MassSnapshot | None = None


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


@dataclass(frozen=True, slots=True)
class MotionSnapshot:
    """One degree of freedom of a joint.

    Attributes:
        kind: `rotation` or `translation`, of `one` relative to `two`.
        axis: Unit vector, as `two` has it: not carried by the joint's motions before it.
        value: Its current value, in [rad] or [m].
        lower, upper: Limits, in [rad] or [m]; None where not enabled.
        role: What the CAD system calls it where a joint has several: `pitch`, `yaw`, `roll`,
            `rotation`, `slide`, `primary_slide`, `secondary_slide`.
    """

    kind: Literal["rotation", "translation"]
    axis: Vector3
    value: float = 0.0
    lower: float | None = None
    upper: float | None = None
    role: str = ""


@dataclass(frozen=True, slots=True)
class JointSnapshot:
    """A joint, or as-built joint, between two occurrences.

    Attributes:
        name: Its name.
        kind: Its type.
        one, two: Paths of the occurrences; `one` moves relative to `two`. None where the CAD system
            does not say.
        origin_one, origin_two: Where the joint is as `one` and `two` have it, in [m]; None where
            the CAD system does not say.
        motions: In their order from `two` to `one`.
        as_built: Whether it is an as-built joint.
        suppressed: Whether it is switched off in the timeline.
        locked: Whether it is locked.
        problem: What the CAD system says is wrong with it; empty if nothing.
    """

    name: str
    kind: JointKind
    one: str | None
    two: str | None
    origin_one: Vector3 | None = None
    origin_two: Vector3 | None = None
    motions: tuple[MotionSnapshot, ...] = ()
    as_built: bool = False
    suppressed: bool = False
    locked: bool = False
    problem: str = ""


@dataclass(frozen=True, slots=True)
class PointSnapshot:
    """A construction point in one place: a via point, task point or marker by name or attributes.

    Attributes:
        name: Its name.
        occurrence: Path of the occurrence that it belongs to.
        position: In [m].
        entity: What the CAD system's component and point are; the same for a point that is in
            several places because its component is.
        attributes: Its attributes in the add-in's group, by name.
        problem: What the CAD system says is wrong with it; empty if nothing.
    """

    name: str
    occurrence: str
    position: Vector3
    entity: str = ""
    attributes: Mapping[str, str] = field(default_factory=dict)
    problem: str = ""


@dataclass(frozen=True, slots=True)
class SurfaceSnapshot:
    """A cylinder or sphere face that muscles wrap over, in one place.

    Attributes:
        occurrence: Path of the occurrence that it belongs to.
        shape: `sphere` or `cylinder`.
        radius: In [m].
        centre: Of the sphere, or of the cylinder's middle, in [m].
        axis: Of the cylinder, a unit vector; z for a sphere.
        length: Of the cylinder, in [m]; 0 for a sphere.
        entity: As for a point.
        attributes: Its attributes in the add-in's group, by name.
    """

    occurrence: str
    shape: Literal["sphere", "cylinder"]
    radius: float
    centre: Vector3
    axis: Vector3 = (0.0, 0.0, 1.0)
    length: float = 0.0
    entity: str = ""
    attributes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class DesignSnapshot:
    """All that the export needs of a design.

    Attributes:
        name: The design's name.
        settings: How to export it.
        occurrences: Every component in every place, but the root.
        bodies: Every body in every place.
        groups: Rigid groups.
        joints: Joints and as-built joints.
        points: Construction points of the add-in, by name or attributes.
        surfaces: Faces that muscles wrap over.
        attributes: The design's attributes in the add-in's group, by name.
        intent: What the design is made for.
        findings: What could not be read.
    """

    name: str
    settings: ExportSettings = field(default_factory=ExportSettings)
    occurrences: tuple[OccurrenceSnapshot, ...] = ()
    bodies: tuple[BodySnapshot, ...] = ()
    groups: tuple[GroupSnapshot, ...] = ()
    joints: tuple[JointSnapshot, ...] = ()
    points: tuple[PointSnapshot, ...] = ()
    surfaces: tuple[SurfaceSnapshot, ...] = ()
    attributes: Mapping[str, str] = field(default_factory=dict)
    intent: DesignIntent = "unknown"
    findings: tuple[Finding, ...] = ()


def snapshot_text(snapshot: DesignSnapshot) -> str:
    """The text of a snapshot's file."""
    plain = {"format": FORMAT, "design": to_plain(snapshot)}
    return json_text(plain, indent=1, sort_keys=True) + "\n"


def write_snapshot(snapshot: DesignSnapshot, file: str | Path) -> Path:
    """Write a snapshot as JSON.

    Raises:
        InputError: The file cannot be written.
    """
    file = Path(file)
    return write_files(file.parent, {file.name: snapshot_text(snapshot)})[0]


def read_snapshot(file: str | Path) -> DesignSnapshot:
    """Read a snapshot from JSON.

    Raises:
        InputError: It cannot be read or is no snapshot; the message names the key.
    """
    file = Path(file)
    try:
        plain = json.loads(read_file(file, _LARGEST).decode())
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not JSON: {error}", file=file) from None
    if not isinstance(plain, dict) or plain.keys() != {"format", "design"}:
        raise InputError("is not a design snapshot of this add-in", file=file)
    if plain["format"] != FORMAT:
        what = f"has format {plain['format']!r}, this version reads {FORMAT}"
        raise InputError(what, file=file, key="format")
    try:
        return from_plain(DesignSnapshot, plain["design"], "design")
    except InputError as error:
        raise InputError(error.what, file=file, key=error.key) from None
