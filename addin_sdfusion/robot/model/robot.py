"""Robot description: links, joints, muscles and task frames, as immutable dataclasses.

All values are in SI units. Joints, via points, centres of mass and task points are expressed in
link frames. The joints form a tree: every link is the child of exactly one joint, and `WORLD` is
the root. Joints are listed parents first; their order defines the order of the coordinates q. Loop
joints have no coordinates and close loops between links of the tree.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, wraps
from importlib import import_module
from typing import Any, Literal, TypeVar, cast

from ..errors import UnknownNameError
from .joint import Coordinate, Joint
from .loop import LoopJoint
from .muscle import CableSet, Muscle, WrapSurface
from .pose import IDENTITY, Pose, Vector3
from .rotations import Matrix3, add, apply, point_inertia, rotate_inertia, subtract
from .transform import Transform

Axis = Literal["x", "y", "z", "alpha", "beta", "gamma"]
POSITIONS: tuple[Axis, ...] = ("x", "y", "z")
ANGLES: tuple[Axis, ...] = ("alpha", "beta", "gamma")

WORLD = "world"
"""Name of the fixed frame. It can be used like a link as a parent and for via points."""

DEFAULT_SET = "cardsflow"
"""Name of the only cable set and task set in files that do not name them."""
MARKERS = "markers"
"""Name of the task set with markers, which are reported but not controlled."""

GRAVITY: Vector3 = (0.0, 0.0, -9.81)
"""Default gravity, in [m/s²]: CASPR's value, z up."""


@dataclass(frozen=True, slots=True)
class Inertia:
    """Mass, centre of mass and inertia matrix of a link.

    Attributes:
        mass: In [kg].
        com: Centre of mass in the link frame, in [m].
        ixx, iyy, izz, ixy, ixz, iyz: Entries of the inertia matrix about the centre of mass, along
            the axes of the link frame, in [kg·m²]. Off-diagonal entries have the sign of the
            matrix: ixy = -∫ x y dm.
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
    def of(mass: float, com: Vector3, matrix: Matrix3) -> Inertia:
        """Create an inertia from mass, centre of mass and matrix about it, in [kg·m²]."""
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix
        return Inertia(mass, com, xx, yy, zz, xy, xz, yz)

    @staticmethod
    def of_origin(mass: float, com: Vector3, matrix: Matrix3) -> Inertia:
        """Create an inertia like `of`, from the matrix about the origin of the frame."""
        x, y, z = map(subtract, matrix, point_inertia(mass, com))
        return Inertia.of(mass, com, (x, y, z))

    @staticmethod
    def of_bodies(bodies: Sequence[Inertia]) -> Inertia:
        """Return the inertia of rigidly connected bodies; the com is at the origin without mass."""
        if len(bodies) == 1:
            return bodies[0]
        mass = sum(body.mass for body in bodies)
        moments = (sum(body.mass * body.com[i] for body in bodies) for i in range(3))
        x, y, z = (moment / mass if mass else 0.0 for moment in moments)
        matrices = [body.about((x, y, z)) for body in bodies]
        rows = (tuple(sum(A[i][j] for A in matrices) for j in range(3)) for i in range(3))
        return Inertia.of(mass, (x, y, z), tuple(rows))  # type: ignore[arg-type]

    @property
    def entries(self) -> tuple[float, ...]:
        """Entries xx, yy, zz, xy, xz, yz of the inertia matrix, in [kg·m²]."""
        return self.ixx, self.iyy, self.izz, self.ixy, self.ixz, self.iyz

    @property
    def matrix(self) -> Matrix3:
        """Rows of the symmetric inertia matrix, in [kg·m²]."""
        return (
            (self.ixx, self.ixy, self.ixz),
            (self.ixy, self.iyy, self.iyz),
            (self.ixz, self.iyz, self.izz),
        )

    @property
    def radius_of_gyration(self) -> float:
        """√(½ tr I / m), in [m]; zero for zero mass or inertia."""
        square = 0.5 * (self.ixx + self.iyy + self.izz)
        return math.sqrt(square / self.mass) if square > 0.0 and self.mass > 0.0 else 0.0

    def about(self, point: Vector3) -> Matrix3:
        """Return the inertia matrix about a point of the frame, in [kg·m²]."""
        x, y, z = map(add, self.matrix, point_inertia(self.mass, subtract(self.com, point)))
        return x, y, z

    def moved(self, T_a_b: Transform) -> Inertia:
        """Return the inertia, which is expressed in frame b, in frame a."""
        matrix = rotate_inertia(T_a_b.R, self.matrix)
        return Inertia.of(self.mass, T_a_b.apply(self.com), matrix)

    def in_frame(self, T_a_b: Pose) -> Inertia:
        """Return the inertia in frame a, from the pose of its frame b; see `moved`."""
        if not any(T_a_b.rpy):
            return replace(self, com=apply(T_a_b, self.com))
        return self.moved(Transform.of(T_a_b))

    def scaled(self, factor: float) -> Inertia:
        """Return the inertia of the same body with another density.

        Args:
            factor: The new density over the old one.
        """
        return Inertia(factor * self.mass, self.com, *(factor * entry for entry in self.entries))


Rgba = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Mesh:
    """A triangle mesh of a link.

    Attributes:
        role: `visual` or `collision`.
        uri: URI of the mesh file, as in the robot's file.
        pose: Pose in the link's frame.
        scale: Factors along x, y, z that convert the units of the file to metres.
        name: Name in the robot's file; may be empty.
        color: Red, green, blue and opacity of a visual mesh, from 0 to 1; None if unknown.
    """

    role: Literal["visual", "collision"]
    uri: str
    pose: Pose = IDENTITY
    scale: Vector3 = (1.0, 1.0, 1.0)
    name: str = ""
    color: Rgba | None = None


ShapeKind = Literal["box", "sphere", "cylinder"]
SHAPE_SIZES: dict[ShapeKind, int] = {"box": 3, "sphere": 1, "cylinder": 2}
"""Number of sizes of each shape."""


@dataclass(frozen=True, slots=True)
class Shape:
    """A primitive collision shape, centred at the origin of its frame.

    Attributes:
        kind: Kind of shape; the axis of a cylinder is z.
        sizes: Edges along x, y, z of a box; radius of a sphere; radius and length of a cylinder, in
            [m].
        pose: Pose in the link's frame.
    """

    kind: ShapeKind
    sizes: tuple[float, ...]
    pose: Pose = IDENTITY


@dataclass(frozen=True, slots=True)
class Link:
    """A rigid body.

    Attributes:
        name: Name, unique among the links.
        inertia: Mass properties.
        end: Distal end in the link frame, in [m], only used for drawing; None if unknown.
        meshes: Visual and collision meshes.
        shapes: Collision shapes, in addition to meshes.
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
        name: Name, unique in its task set.
        link: Link of the frame.
        position: In that link's frame, in [m]; the origin for an orientation.
        axes: Task coordinates, in order: x, y, z of the point in the world, or the angles alpha,
            beta, gamma of R_world_link = Rx(alpha) Ry(beta) Rz(gamma), in [rad]. In both cases the
            task Jacobian satisfies y' = J q'.
    """

    name: str
    link: str
    position: Vector3 = (0.0, 0.0, 0.0)
    axes: tuple[Axis, ...] = ("x", "y", "z")

    @property
    def is_orientation(self) -> bool:
        """Whether the task coordinates are angles instead of positions."""
        return bool(self.axes) and self.axes[0] in ANGLES


@dataclass(frozen=True, slots=True)
class TaskSet:
    """A named operational space. Its task coordinates y are the axes of its frames, in order."""

    name: str
    frames: tuple[TaskFrame, ...]


_Named = TypeVar(
    "_Named", Link, Joint, LoopJoint, Coordinate, Muscle, CableSet, TaskSet, WrapSurface
)


def find(kind: str, name: str, items: Sequence[_Named]) -> _Named:
    """Return the item of that name.

    Raises:
        UnknownNameError: The name does not exist. The message suggests a similar name and lists
            all.
    """
    for item in items:
        if item.name == name:
            return item
    raise UnknownNameError(kind, name, [item.name for item in items])


@dataclass(frozen=True)
class Robot:
    """A tree of links with muscles and optional loop joints.

    `check(robot)` returns its errors and warnings.

    Attributes:
        name: Name of the robot.
        links: Links, in any order.
        joints: Joints, parents first.
        cable_sets: Alternative sets of muscles; may be empty.
        cable_set: Name of the active cable set, or empty.
        task_sets: Operational spaces; may be empty.
        task_set: Name of the active operational space, or empty.
        gravity: In the world frame, in [m/s²].
        wrap_surfaces: Surfaces over which muscles can wrap.
        loops: Loop joints, in any order.
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

    def show(self, folder: Any = None) -> Any:
        """Return a page that a notebook displays; outside of notebooks, open the browser.

        Args:
            folder: Folder of the robot with its meshes (default: none, links are capsules).
        """
        # The viewer is part of another package, which this package must not require.
        return import_module("cardsflow_fmu.results.viewer.inline").show(self, folder)

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The free coordinates (neither coupled nor locked), in the order of q."""
        return tuple(c for c in self.all_coordinates if c.is_free)

    @cached_property
    def all_coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates of all joints, including coupled and locked ones."""
        return tuple(c for joint in self.joints for c in joint.coordinates)

    @property
    def driven_joints(self) -> tuple[Joint, ...]:
        """The joints with functions, couplings or locks between q and the motions."""
        return tuple(joint for joint in self.joints if not joint.is_plain)

    @property
    def motors(self) -> tuple[Coordinate, ...]:
        """The coordinates that have a motor, in the order of q."""
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
        """Return the robot with another active cable set.

        Raises:
            UnknownNameError: The cable set does not exist.
        """
        return replace(self, cable_set=find("cable set", name, self.cable_sets).name)

    def with_muscles(self, muscles: Iterable[Muscle]) -> Robot:
        """Return the same robot with the muscles of the active cable set replaced."""
        changed = CableSet(self.cable_set, tuple(muscles))
        sets = tuple(changed if s.name == self.cable_set else s for s in self.cable_sets)
        return replace(self, cable_sets=sets)


_Result = TypeVar("_Result")


def cached_on_robot(compute: Callable[[Robot], _Result]) -> Callable[[Robot], _Result]:
    """Decorate a function so that its result is cached on the robot, which is immutable."""
    key = f"{compute.__module__}.{compute.__qualname__}"

    @wraps(compute)
    def cached(robot: Robot) -> _Result:
        cache = vars(robot)
        if key not in cache:
            cache[key] = compute(robot)
        return cast(_Result, cache[key])

    return cached
