"""Data model of the API objects: plain data that the wrappers read and edit.

An occurrence in a context is a path: a tuple of OccurrenceData, starting at the component of the
context.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import count
from typing import Any

import numpy as np

from ..maths import rotation, translation
from .shapes import NOTHING, Mass, Shape, total

Path = tuple["OccurrenceData", ...]
_ids = count(1)


@dataclass(eq=False)
class Named:
    """Common properties of most entities."""

    name: str
    attributes: dict[tuple[str, str], str] = field(default_factory=dict)
    light_bulb: bool = True
    gone: bool = False


@dataclass(eq=False)
class BodyData(Named):
    """A body. `kind`: `solid`, `surface` or `mesh`."""

    component: Any = None
    shape: Shape | None = None
    kind: str = "solid"
    material: str = "Steel"
    density: float | None = None
    color: tuple[int, int, int] = (160, 160, 160)
    opacity: float = 1.0
    parts: tuple[list, list, list] | None = None

    def mass(self) -> Mass:
        """Mass properties in the frame of the component."""
        return self.shape.mass(self.density) if self.kind == "solid" else NOTHING

    def topology(self) -> tuple[list, list, list]:
        """Vertices, edges and faces (TopologyData)."""
        if self.parts is None:
            found = self.shape.parts()
            kinds = ("vertex", "edge", "face")
            self.parts = tuple(
                [
                    TopologyData(f"{kind}{i}", body=self, kind=kind, geometry=g)
                    for i, g in enumerate(geometries)
                ]
                for kind, geometries in zip(kinds, found, strict=True)
            )
        return self.parts


@dataclass(eq=False)
class TopologyData(Named):
    """A vertex, an edge or a face of a body, in the frame of the component."""

    body: Any = None
    kind: str = "vertex"
    geometry: Any = None

    @property
    def component(self) -> Any:
        """The component of its body."""
        return self.body.component


@dataclass(eq=False)
class PointData(Named):
    """A construction point. `position` is in the frame of its component."""

    component: Any = None
    position: Any = None
    definition: tuple[str, Any, Path] | None = None
    health: int = 0
    problem: str = ""
    by_user: bool = True


@dataclass(eq=False)
class SketchData(Named):
    """A sketch. `T` is the frame of its plane in the component."""

    component: Any = None
    T: Any = None
    points: list[SketchPointData] = field(default_factory=list)


@dataclass(eq=False)
class SketchPointData(Named):
    """A point of a sketch, in the frame of the sketch."""

    sketch: Any = None
    position: Any = None

    @property
    def component(self) -> Any:
        """The component of its sketch."""
        return self.sketch.component


@dataclass(eq=False)
class GroupData(Named):
    """A rigid group. `members` are paths; `stale` groups have lost their occurrences."""

    component: Any = None
    members: list[Path] = field(default_factory=list)
    suppressed: bool = False
    health: int = 0
    problem: str = ""
    stale: bool = False


@dataclass(eq=False)
class JointOriginData(Named):
    """A joint origin: a frame in its component."""

    component: Any = None
    T: Any = None


@dataclass
class Limits:
    """Limits of one degree of freedom; values are 0 unless the user sets them."""

    minimum: float = 0.0
    maximum: float = 0.0
    rest: float = 0.0
    has_minimum: bool = False
    has_maximum: bool = False


@dataclass
class Freedom:
    """One degree of freedom of a joint.

    Attributes:
        role: `rotation`, `slide`, `primarySlide`, `secondarySlide`, `pitch`, `yaw`, `roll`.
        axis: Direction in the joint frame on occurrenceTwo, at the zero pose.
        value: In [rad] or [cm].
        limits: Its limits.
    """

    role: str
    axis: Any
    value: float = 0.0
    limits: Limits = field(default_factory=Limits)

    @property
    def turns(self) -> bool:
        """Whether it rotates."""
        return "lide" not in self.role


@dataclass(eq=False)
class JointData(Named):
    """A joint or as-built joint, in its component.

    Attributes:
        kind: `joint` or `as-built`.
        type: Its JointTypes value.
        one, two: Paths from its component; empty for the component itself.
        T_one, T_two: Joint frame in the frames of `one` and `two`; None if not defined.
        origin_one, origin_two: JointOriginData that define the frames, if any.
        dragged: Whether the user has dragged the joint, which rounds its angles to 0.1 degrees.
    """

    component: Any = None
    kind: str = "joint"
    type: int = 0
    one: Path = ()
    two: Path = ()
    T_one: Any = None
    T_two: Any = None
    origin_one: JointOriginData | None = None
    origin_two: JointOriginData | None = None
    freedoms: list[Freedom] = field(default_factory=list)
    suppressed: bool = False
    locked: bool = False
    flipped: bool = False
    health: int = 0
    problem: str = ""
    offsets: tuple[float, float, float] = (0.0, 0.0, 0.0)
    angle: float = 0.0
    broken_geometry: bool = False
    dragged: bool = False


@dataclass(eq=False)
class MotionLinkData(Named):
    """A motion link.

    Attributes:
        joint_one, joint_two: Linked joints; `joint_two` is None for two motions of one joint.
        motions: JointMotionTypes values.
        values: Displacements of both motions, whose ratio is constant, in [rad] or [cm].
        reversed: Whether the second motion has the opposite direction.
    """

    component: Any = None
    joint_one: Any = None
    joint_two: Any = None
    motions: tuple[int, int] = (10, 10)
    values: tuple[float, float] = (1.0, 1.0)
    reversed: bool = False
    suppressed: bool = False
    health: int = 0
    problem: str = ""


@dataclass(eq=False)
class GraphicsData(Named):
    """A custom graphics group or one of its entities."""

    kind: str = "group"
    items: list[GraphicsData] = field(default_factory=list)
    fields: dict[str, Any] = field(default_factory=dict)
    parent: Any = None


@dataclass(eq=False)
class OccurrenceData(Named):
    """An occurrence of a component.

    Attributes:
        T: Pose in the parent component, unless `poses` of a parent overrides it.
        unresolved: Whether the document of its component cannot be found.
        suppressed: Whether it is suppressed; the API does not list it then.
        captured: Captured pose, if the occurrence was moved without capturing the position.
    """

    component: Any = None
    parent: Any = None
    T: Any = None
    grounded: bool = False
    ground_to_parent: bool = False
    unresolved: bool = False
    suppressed: bool = False
    captured: Any = None


@dataclass(eq=False)
class ComponentData(Named):
    """A component.

    Attributes:
        referenced: Whether it belongs to another document.
        source: Design of this document, if needed.
        id: Persistent id, which copies of a document share.
        poses: Poses of occurrences in a sub-assembly whose joints are moved in this component: by
            path from this component, relative to the parent occurrence.
    """

    design: Any = None
    referenced: bool = False
    source: Any = None
    bodies: list[BodyData] = field(default_factory=list)
    mesh_bodies: list[BodyData] = field(default_factory=list)
    occurrences: list[OccurrenceData] = field(default_factory=list)
    points: list[PointData] = field(default_factory=list)
    sketches: list[SketchData] = field(default_factory=list)
    joints: list[JointData] = field(default_factory=list)
    as_built: list[JointData] = field(default_factory=list)
    groups: list[GroupData] = field(default_factory=list)
    joint_origins: list[JointOriginData] = field(default_factory=list)
    graphics: list[GraphicsData] = field(default_factory=list)
    base_features: list[Any] = field(default_factory=list)
    constraints: list[str] = field(default_factory=list)
    motion_links: list[MotionLinkData] = field(default_factory=list)
    tangents: list[str] = field(default_factory=list)
    poses: dict[Path, Any] = field(default_factory=dict)
    id: str = field(default_factory=lambda: f"{next(_ids):032x}")
    user_mass: float | None = None
    opacity: float = 1.0
    material: str = "Steel"

    @property
    def shown(self) -> list[OccurrenceData]:
        """Occurrences that are not suppressed."""
        return [o for o in self.occurrences if not o.suppressed]

    def mass(self, above: Path = ()) -> Mass:
        """Return the mass properties including all children, in the frame of the component.

        Args:
            above: Path of the component.
        """
        parts = [b.mass() for b in self.bodies]
        for o in self.shown:
            path = (*above, o)
            parts.append(o.component.mass(path).moved(relative_pose(path)))
        whole = total(parts)
        return whole if self.user_mass is None else whole.with_mass(self.user_mass)


@dataclass(eq=False)
class DesignData(Named):
    """A design, in its document."""

    root: ComponentData = None  # type: ignore[assignment]
    components: list[ComponentData] = field(default_factory=list)
    kind: int = 1
    intent: int = 2
    units: str = "mm"
    product: str = "DesignProductType"
    counters: dict[int, int] = field(default_factory=dict)

    def is_edited(self) -> bool:
        """Whether a base feature is edited; the design is then treated as a direct design."""
        return any(f.is_edited for c in self.components for f in c.base_features)


def transform(path: Path) -> np.ndarray:
    """Return the pose of an occurrence in its context: the product of the poses on its path."""
    if not path:
        return np.eye(4)
    T = relative_pose(path[:1])
    for k in range(2, len(path) + 1):
        T = T @ relative_pose(path[:k])
    return T


def relative_pose(path: Path) -> np.ndarray:
    """Return the pose of the last occurrence of a path relative to its parent.

    The pose in `poses` of the topmost component takes precedence.
    """
    for k in range(len(path)):
        poses = path[k].parent.poses
        if poses and path[k:] in poses:
            return poses[path[k:]]
    return path[-1].T


def first_instance(component: ComponentData) -> Path:
    """Return the path of the first occurrence of a component; empty for the root component."""
    places = paths_below(component.design.root)
    return next((path for path in places if path[-1].component is component), ())


def motion(freedoms: list[Freedom]) -> np.ndarray:
    """Return the pose of `one` relative to `two` in the joint frame: the product of all motions."""
    T = np.eye(4)
    for f in freedoms:
        axis = np.asarray(f.axis, dtype=float)
        T = T @ (rotation(f.value, axis) if f.turns else translation(f.value * axis))
    return T


def paths_below(component: ComponentData, above: Path = ()) -> list[Path]:
    """Return the paths of all occurrences below a component, depth first."""
    found: list[Path] = []
    for occurrence in component.shown:
        path = (*above, occurrence)
        found.append(path)
        found += paths_below(occurrence.component, path)
    return found
