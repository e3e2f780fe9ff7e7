"""Robot description: links, joints, cables, task frames. Plain, frozen, standard library only.

Conventions: SI units. Every link has a frame; joints, via points, centres of mass and task points
are given in link frames. The joints make a tree: every link is the child of exactly one, and the
root of the tree is `WORLD`. They are listed parents first; that order is the order of the
coordinates q. Loop joints, which have no coordinates, close loops between links of the tree.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, wraps
from typing import Literal, TypeVar, cast

from ..errors import UnknownNameError
from .joint import Coordinate, Joint
from .loop import LoopJoint
from .muscle import CableSet, Muscle, WrapSurface
from .pose import IDENTITY, Pose, Vector3

Axis = Literal["x", "y", "z", "alpha", "beta", "gamma"]
POSITIONS: tuple[Axis, ...] = ("x", "y", "z")
ANGLES: tuple[Axis, ...] = ("alpha", "beta", "gamma")

WORLD = "world"
"""The name of the fixed frame, usable wherever a link is named as parent or for a via point."""

MARKERS = "markers"
"""The task set of the points that are only looked at."""

GRAVITY: Vector3 = (0.0, 0.0, -9.81)
"""Gravity unless a robot says otherwise, in [m/s²]: CASPR's value, z up."""


@dataclass(frozen=True, slots=True)
class Inertia:
    """Mass, centre of mass and inertia matrix of a link.

    Attributes:
        mass: In [kg].
        com: Centre of mass in the link frame, in [m].
        ixx, iyy, izz, ixy, ixz, iyz: Entries of the inertia matrix about the centre of mass, along
            the axes of the link frame, in [kg·m²]. Off-diagonal entries carry the matrix' sign:
            ixy = -∫ x y dm.
    """

    mass: float
    com: Vector3 = (0.0, 0.0, 0.0)
    ixx: float = 0.0
    iyy: float = 0.0
    izz: float = 0.0
    ixy: float = 0.0
    ixz: float = 0.0
    iyz: float = 0.0

    @staticmethod
    def of(mass: float, com: Vector3, matrix: tuple[Vector3, Vector3, Vector3]) -> Inertia:
        """From the inertia matrix about the centre of mass, row by row, in [kg·m²]."""
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix
        return Inertia(mass, com, xx, yy, zz, xy, xz, yz)

    @property
    def matrix(self) -> tuple[Vector3, Vector3, Vector3]:
        """The symmetric inertia matrix, row by row, in [kg·m²]."""
        return (
            (self.ixx, self.ixy, self.ixz),
            (self.ixy, self.iyy, self.iyz),
            (self.ixz, self.iyz, self.izz),
        )

    def scaled(self, factor: float) -> Inertia:
        """Return the inertia of the same body with another density.

        Args:
            factor: The new density over the old one.
        """
        return Inertia(
            factor * self.mass,
            self.com,
            *(factor * entry for entry in (self.ixx, self.iyy, self.izz)),
            *(factor * entry for entry in (self.ixy, self.ixz, self.iyz)),
        )


Rgba = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Mesh:
    """A triangle mesh of a link.

    Attributes:
        role: `visual` or `collision`.
        uri: Where the file is, as the robot's file says it.
        pose: In the link's frame.
        scale: Factors along x, y, z that make metres of the file's units.
        name: Its name in the robot's file; may be empty.
        color: Of a visual one: red, green, blue and opacity from 0 to 1; None if not known.
    """

    role: Literal["visual", "collision"]
    uri: str
    pose: Pose = IDENTITY
    scale: Vector3 = (1.0, 1.0, 1.0)
    name: str = ""
    color: Rgba | None = None


ShapeKind = Literal["box", "sphere", "cylinder"]
SHAPE_SIZES: dict[ShapeKind, int] = {"box": 3, "sphere": 1, "cylinder": 2}
"""How many sizes a shape has."""


@dataclass(frozen=True, slots=True)
class Shape:
    """A simple shape that a link collides with, its middle at its frame's origin.

    Attributes:
        kind: What it is; a cylinder is along z.
        sizes: The edges along x, y, z; the radius; or the radius and the length, in [m].
        pose: In the link's frame.
    """

    kind: ShapeKind
    sizes: tuple[float, ...]
    pose: Pose = IDENTITY


@dataclass(frozen=True, slots=True)
class Link:
    """A rigid body.

    Attributes:
        name: Its name, unique among the links.
        inertia: Mass properties.
        end: The far end in the link frame, in [m]; for drawing only, None if unknown.
        meshes: What it looks like and what it collides with.
        shapes: What it collides with beside meshes.
    """

    name: str
    inertia: Inertia
    end: Vector3 | None = None
    meshes: tuple[Mesh, ...] = ()
    shapes: tuple[Shape, ...] = ()


@dataclass(frozen=True, slots=True)
class TaskFrame:
    """A point on a link whose position is controlled or reported, or the link's orientation.

    Attributes:
        name: Its name, unique in its task set.
        link: The link it is fixed to.
        position: In that link's frame, in [m]; the origin for an orientation.
        axes: Which task coordinates count, in order: world axes x, y, z of the point, or the angles
            alpha, beta, gamma of R_world_link = Rx(alpha) Ry(beta) Rz(gamma), in [rad]. The task
            Jacobian is that of these coordinates: y' = J q' for both.
    """

    name: str
    link: str
    position: Vector3 = (0.0, 0.0, 0.0)
    axes: tuple[Axis, ...] = ("x", "y", "z")

    @property
    def is_orientation(self) -> bool:
        """Whether it counts angles, instead of positions."""
        return bool(self.axes) and self.axes[0] in ANGLES


@dataclass(frozen=True, slots=True)
class TaskSet:
    """A named operational space: the task coordinates y are its frames' axes, in order."""

    name: str
    frames: tuple[TaskFrame, ...]


_Named = TypeVar(
    "_Named", Link, Joint, LoopJoint, Coordinate, Muscle, CableSet, TaskSet, WrapSurface
)


def find(kind: str, name: str, items: Sequence[_Named]) -> _Named:
    """Return the item of that name.

    Raises:
        UnknownNameError: There is none; the message names the nearest and lists all.
    """
    for item in items:
        if item.name == name:
            return item
    raise UnknownNameError(kind, name, [item.name for item in items])


@dataclass(frozen=True)
class Robot:
    """A tree of links with muscles, and joints that close loops in it.

    `check(robot)` lists what is wrong with it.

    Attributes:
        name: Its name.
        links: In any order.
        joints: Parents first.
        cable_sets: The alternatives; may be empty.
        cable_set: Name of the active one; empty if it does not exist.
        task_sets: Operational spaces; may be empty.
        task_set: Name of the active one; empty if it does not exist.
        gravity: In the world frame, in [m/s²].
        wrap_surfaces: What muscles may wrap over.
        loops: Joints that close loops; in any order.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    cable_sets: tuple[CableSet, ...] = ()
    cable_set: str = ""
    task_sets: tuple[TaskSet, ...] = ()
    task_set: str = ""
    gravity: Vector3 = GRAVITY
    wrap_surfaces: tuple[WrapSurface, ...] = ()
    loops: tuple[LoopJoint, ...] = ()

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates in the order of q: those that are neither coupled nor locked."""
        return tuple(c for c in self.all_coordinates if c.is_free)

    @cached_property
    def all_coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates of all joints, coupled and locked ones as well."""
        return tuple(c for joint in self.joints for c in joint.coordinates)

    @property
    def driven_joints(self) -> tuple[Joint, ...]:
        """The joints in which functions, couplings or locks stand between q and the motions."""
        return tuple(joint for joint in self.joints if not joint.is_plain)

    @property
    def motors(self) -> tuple[Coordinate, ...]:
        """The coordinates with a motor of their own, in the order of q."""
        return tuple(c for c in self.coordinates if c.actuated)

    @cached_property
    def muscles(self) -> tuple[Muscle, ...]:
        """The muscles of the active cable set, in the order of f."""
        if not self.cable_set:
            return ()
        return find("cable set", self.cable_set, self.cable_sets).muscles

    @property
    def task_frames(self) -> tuple[TaskFrame, ...]:
        """The frames of the active operational space, in the order of y."""
        if not self.task_set:
            return ()
        return find("operational space", self.task_set, self.task_sets).frames

    def link(self, name: str) -> Link:
        """Return the link of that name; raise UnknownNameError if it does not exist."""
        return self._links.get(name) or find("link", name, self.links)

    def joint(self, name: str) -> Joint:
        """Return the joint of that name; raise UnknownNameError if it does not exist."""
        return find("joint", name, self.joints)

    def wrap_surface(self, name: str) -> WrapSurface:
        """Return the wrap surface of that name; raise UnknownNameError if it does not exist."""
        return self._wrap_surfaces.get(name) or find("wrap surface", name, self.wrap_surfaces)

    def muscle(self, name: str) -> Muscle:
        """Return the active muscle of that name; raise UnknownNameError if it does not exist."""
        return self._muscles.get(name) or find("muscle", name, self.muscles)

    @cached_property
    def _links(self) -> dict[str, Link]:
        return {link.name: link for link in reversed(self.links)}

    @cached_property
    def _muscles(self) -> dict[str, Muscle]:
        return {muscle.name: muscle for muscle in reversed(self.muscles)}

    @cached_property
    def _wrap_surfaces(self) -> dict[str, WrapSurface]:
        return {surface.name: surface for surface in reversed(self.wrap_surfaces)}

    def with_cable_set(self, name: str) -> Robot:
        """The same robot with another cable set active; UnknownNameError if there is none."""
        return replace(self, cable_set=find("cable set", name, self.cable_sets).name)

    def with_muscles(self, muscles: Iterable[Muscle]) -> Robot:
        """Return the same robot with the muscles of the active cable set replaced."""
        changed = CableSet(self.cable_set, tuple(muscles))
        sets = tuple(changed if s.name == self.cable_set else s for s in self.cable_sets)
        return replace(self, cable_sets=sets)


_Result = TypeVar("_Result")


def cached_on_robot(compute: Callable[[Robot], _Result]) -> Callable[[Robot], _Result]:
    """A function whose result a robot keeps, as that of a cached property: no robot changes."""
    key = f"{compute.__module__}.{compute.__qualname__}"

    @wraps(compute)
    def kept(robot: Robot) -> _Result:
        known = vars(robot)
        if key not in known:
            known[key] = compute(robot)
        return cast(_Result, known[key])

    return kept
