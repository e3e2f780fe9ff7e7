"""Snapshot of a design as plain records: all that an export needs of a CAD system.

SI units. Positions and directions are given in the design's root frame, at the
design's pose. An occurrence is named by its full path, such as `arm:1+hand:1`; the root component
has the empty path. `snapshot_file` writes and reads them; `docs/snapshot.md` describes the file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from .records import Form, Samples
from .robot.finding import Finding
from .robot.model.muscle import CableKind
from .robot.model.pose import Vector3
from .robot.model.robot import Axis
from .settings import ExportSettings

ROOT = ""
"""Path of the root component."""

JointKind = Literal[
    "rigid", "revolute", "slider", "cylindrical", "pin_slot", "planar", "ball", "inferred"
]
DesignIntent = Literal["part", "assembly", "hybrid", "unknown"]
Role = Literal["via", "task", "marker"]
COLOR = re.compile("#[0-9a-fA-F]{6}", re.ASCII)
Color = Annotated[str, Form("#rrggbb", COLOR.pattern)]

DEFAULT_COLOR = "#d62728"
F_MIN, F_MAX = 10.0, 80.0
"""Force limits of a muscle of which nothing is known, in [N]: those of the add-in before."""


@dataclass(frozen=True, slots=True)
class SourceSnapshot:
    """Where a snapshot comes from.

    Attributes:
        program: The CAD system or the library, such as `Fusion` or `build123d`.
        version: Its version.
        document: The design's document, file or address there.
    """

    program: str = ""
    version: str = ""
    document: str = ""


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
        mass: Mass properties; None where there are none.
        material: Name of its material; empty if it has none.
        mesh: Its triangles; None where they were not asked for.
        color: Its colour; None where the CAD system does not say.
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
            for the component; None where there are none.
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
        damping: Viscous damping, in [N·m·s/rad] or [N·s/m].
        friction: Coulomb friction, in [N·m] or [N].
        stiffness: Of a spring, in [N·m/rad] or [N/m].
        rest: Where the spring makes no torque or force, in [rad] or [m].
        effort: Largest torque or force of its motor, in [N·m] or [N]; None where not known.
    """

    kind: Literal["rotation", "translation"]
    axis: Vector3
    value: float = 0.0
    lower: float | None = None
    upper: float | None = None
    role: str = ""
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    effort: float | None = None


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
class CouplingSnapshot:
    """A motion that follows another one: follower = ratio · leader + offset.

    Attributes:
        follower, leader: Names of the joints.
        ratio: Without unit, or in [m/rad] or [rad/m].
        offset: In [rad] or [m].
        follower_role, leader_role: Roles of the motions, of joints that have several.
    """

    follower: str
    leader: str
    ratio: float = 1.0
    offset: float = 0.0
    follower_role: str = ""
    leader_role: str = ""


@dataclass(frozen=True, slots=True)
class MuscleSnapshot:
    """A muscle, without its points, which name it.

    Attributes:
        name: Its name.
        color: What it is drawn in.
        f_min: Smallest force that a controller may command, in [N].
        f_max: Largest force, in [N]; infinite where unknown.
        model: How force, length and stiffness belong together.
        parameters: The model's numbers by name, in SI units.
    """

    name: str
    color: Color = DEFAULT_COLOR
    f_min: float = F_MIN
    f_max: float = F_MAX
    model: CableKind = "ideal"
    parameters: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class PointUse:
    """What a construction point is.

    Attributes:
        role: `via`, `task` or `marker`.
        link: Name of the link it is fixed to, or `world`; that of its occurrence if empty.
        muscle: Of a via point: name of the muscle.
        number: Of a via point: its place along the muscle.
        name: Of a task point or marker: its name.
        axes: Of a task point: which coordinates count; the position's if empty.
        occurrence: Path of the occurrence that is meant where the component is in several places.
        made: Whether the add-in made the point, and so may delete it.
        original: The name that the user gave a point that the add-in did not make.
    """

    role: Role
    link: str = ""
    muscle: str = ""
    number: int = 0
    name: str = ""
    axes: tuple[Axis, ...] = ()
    occurrence: str = ""
    made: bool = False
    original: str = ""


@dataclass(frozen=True, slots=True)
class WrapUse:
    """A muscle that wraps over a surface.

    Attributes:
        muscle: Name of the muscle.
        after: Number of the via point before the surface.
        side: 1 or -1 for a chosen sense of turning about the axis, 0 for the shorter path.
        turns: Whole turns about it.
        inside: Whether it is led through the surface; then it has no side and no turns.
    """

    muscle: str
    after: int
    side: Literal[-1, 0, 1] = 0
    turns: int = 0
    inside: bool = False


@dataclass(frozen=True, slots=True)
class SurfaceUse:
    """What a face is.

    Attributes:
        name: Name of the wrap surface.
        link: Name of the link it is fixed to, or `world`; that of its occurrence if empty.
        muscles: Which muscles wrap over it.
        occurrence: Path of the occurrence that is meant where the component is in several places.
    """

    name: str
    link: str = ""
    muscles: tuple[WrapUse, ...] = ()
    occurrence: str = ""


@dataclass(frozen=True, slots=True)
class PointSnapshot:
    """A construction point in one place: a via point, task point or marker.

    Attributes:
        name: Its name.
        occurrence: Path of the occurrence that it belongs to.
        position: In [m].
        entity: What the CAD system's component and point are; the same for a point that is in
            several places because its component is.
        use: What it is; None where its name says it, as in designs of earlier add-ins:
            `VP_motor<number>_EXPORT_<link>_<number>`, `EE_<link>`, `VM_<link>`.
        problem: What the CAD system says is wrong with it; empty if nothing.
    """

    name: str
    occurrence: str
    position: Vector3
    entity: str = ""
    use: PointUse | None = None
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
        use: What it is; None for a face that no muscle wraps over.
    """

    occurrence: str
    shape: Literal["sphere", "cylinder"]
    radius: float
    centre: Vector3
    axis: Vector3 = (0.0, 0.0, 1.0)
    length: float = 0.0
    entity: str = ""
    use: SurfaceUse | None = None


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
        points: Via points, task points and markers.
        surfaces: Faces that muscles wrap over.
        muscles: The muscles in their order, which is that of the forces.
        intent: What the design is made for.
        findings: What could not be read.
        source: Where it comes from.
        couplings: Motions that follow others.
    """

    name: str
    settings: ExportSettings = field(default_factory=ExportSettings)
    occurrences: tuple[OccurrenceSnapshot, ...] = ()
    bodies: tuple[BodySnapshot, ...] = ()
    groups: tuple[GroupSnapshot, ...] = ()
    joints: tuple[JointSnapshot, ...] = ()
    points: tuple[PointSnapshot, ...] = ()
    surfaces: tuple[SurfaceSnapshot, ...] = ()
    muscles: tuple[MuscleSnapshot, ...] = ()
    intent: DesignIntent = "unknown"
    findings: tuple[Finding, ...] = ()
    source: SourceSnapshot = field(default_factory=SourceSnapshot)
    couplings: tuple[CouplingSnapshot, ...] = ()
