"""The model behind the objects of the API: plain data that the wrappers read and edit.

An occurrence in a place is a path: the tuple of OccurrenceData from the context's component down.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..maths import rotation, translation
from .shapes import NOTHING, Mass, Shape, total

Path = tuple["OccurrenceData", ...]


@dataclass(eq=False)
class Named:
    """What most entities have."""

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
        """Mass properties in the component's frame."""
        return self.shape.mass(self.density) if self.kind == "solid" else NOTHING

    def topology(self) -> tuple[list, list, list]:
        """Its vertices, edges and faces (TopologyData)."""
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
    """A vertex, an edge or a face of a body; geometry in the component's frame."""

    body: Any = None
    kind: str = "vertex"
    geometry: Any = None

    @property
    def component(self) -> Any:
        """The component that its body is in."""
        return self.body.component


@dataclass(eq=False)
class PointData(Named):
    """A construction point. `position`: in its component's frame; `source` follows an entity."""

    component: Any = None
    position: Any = None
    definition: tuple[str, Any, Path] | None = None
    health: int = 0
    problem: str = ""
    by_user: bool = True


@dataclass(eq=False)
class SketchData(Named):
    """A sketch. `T`: its plane's frame in the component."""

    component: Any = None
    T: Any = None
    points: list[SketchPointData] = field(default_factory=list)


@dataclass(eq=False)
class SketchPointData(Named):
    """A point of a sketch, in the sketch's frame."""

    sketch: Any = None
    position: Any = None

    @property
    def component(self) -> Any:
        """The component that its sketch is in."""
        return self.sketch.component


@dataclass(eq=False)
class GroupData(Named):
    """A rigid group. `members`: paths from its component; `stale`: its occurrences are gone."""

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
    """Limits of one degree of freedom; values are 0 unless the user types some."""

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
        axis: Direction in the joint's frame on occurrenceTwo, at the zero pose.
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
        T_one, T_two: The joint's frame in the frame of `one` and of `two`; None if there is none.
        origin_one, origin_two: JointOriginData that define them, if any.
        dragged: Whether the user has dragged it: its angles are then on a grid of 0.1 degrees.
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
        joint_one, joint_two: What it links; `joint_two` is None if both motions are of one.
        motions: JointMotionTypes values.
        values: By how much each moves while the other does, in [rad] or [cm].
        reversed: Whether the second moves the other way.
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
    """A component in a place.

    Attributes:
        T: Its pose in the component that holds it, where nothing above says otherwise.
        unresolved: Whether its component's document cannot be found.
        captured: Where it was, if it has been moved since and that is not captured.
    """

    component: Any = None
    parent: Any = None
    T: Any = None
    grounded: bool = False
    ground_to_parent: bool = False
    unresolved: bool = False
    captured: Any = None


@dataclass(eq=False)
class ComponentData(Named):
    """A component.

    Attributes:
        referenced: Whether it lives in another document.
        source: That document's design, where that matters.
        poses: Poses of occurrences within a sub-assembly that differ from those which it has
            elsewhere (its joints are moved here): by path from this component, relative to the
            occurrence above.
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
    user_mass: float | None = None
    opacity: float = 1.0
    material: str = "Steel"

    def mass(self, above: Path = ()) -> Mass:
        """Mass properties with everything below, in the component's frame.

        Args:
            above: Path that the component is seen at.
        """
        parts = [b.mass() for b in self.bodies]
        for o in self.occurrences:
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
        """Whether a base feature is being edited, when the design passes for a direct one."""
        return any(f.is_edited for c in self.components for f in c.base_features)


def transform(path: Path) -> np.ndarray:
    """The pose of an occurrence in its context: the product of the poses on its path."""
    if not path:
        return np.eye(4)
    T = relative_pose(path[:1])
    for k in range(2, len(path) + 1):
        T = T @ relative_pose(path[:k])
    return T


def relative_pose(path: Path) -> np.ndarray:
    """The pose of the last occurrence of a path relative to the one above.

    The highest component that has a pose of its own for it decides.
    """
    for k in range(len(path)):
        poses = path[k].parent.poses
        if poses and path[k:] in poses:
            return poses[path[k:]]
    return path[-1].T


def first_instance(component: ComponentData) -> Path:
    """The first place of a component in its design; empty for the root component."""
    places = paths_below(component.design.root)
    return next((path for path in places if path[-1].component is component), ())


def motion(freedoms: list[Freedom]) -> np.ndarray:
    """Pose of `one` relative to `two`, in the joint's frame: the freedoms one after another."""
    T = np.eye(4)
    for f in freedoms:
        axis = np.asarray(f.axis, dtype=float)
        T = T @ (rotation(f.value, axis) if f.turns else translation(f.value * axis))
    return T


def paths_below(component: ComponentData, above: Path = ()) -> list[Path]:
    """Paths of all occurrences below a component, depth first."""
    found: list[Path] = []
    for occurrence in component.occurrences:
        path = (*above, occurrence)
        found.append(path)
        found += paths_below(occurrence.component, path)
    return found
