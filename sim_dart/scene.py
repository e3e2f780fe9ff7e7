"""Description of the scene around a robot: ground, objects, and collision shapes of links.

A contact uses the smaller friction coefficient of both bodies, and the geometric mean of both
coefficients of restitution.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from addin_sdfusion.robot import IDENTITY, InputError, Pose, Vector3

GROUND = "ground"
"""Name of the ground in the list of bodies of a world."""

MAX_DISTANCE = 1e6
"""Largest size, distance and speed, in [m], [m/s], [rad/s]. ODE aborts for values over 1e15."""

LinkGeometry = Literal["meshes", "capsules", "none"]
FrictionLaw = Literal["pyramid", "cone"]
FRICTION_EXCESS: dict[FrictionLaw, float] = {"pyramid": math.sqrt(2.0) - 1.0, "cone": 0.0}
"""Largest relative excess of the friction force over Coulomb's law."""


@dataclass(frozen=True, slots=True)
class Sphere:
    """Sphere with its centre at the frame origin.

    Attributes:
        radius: Radius, in [m].
    """

    radius: float

    def __post_init__(self) -> None:
        _positive(radius=self.radius)


@dataclass(frozen=True, slots=True)
class Box:
    """Box with its centre at the frame origin.

    Attributes:
        size: Edge lengths along x, y, z, in [m].
    """

    size: Vector3

    def __post_init__(self) -> None:
        for edge in self.size:
            _positive(size=edge)


@dataclass(frozen=True, slots=True)
class Capsule:
    """Capsule along z with its centre at the frame origin.

    Attributes:
        radius: Radius, in [m].
        length: Length of the cylindrical part, in [m].
    """

    radius: float
    length: float

    def __post_init__(self) -> None:
        _positive(radius=self.radius, length=self.length)


@dataclass(frozen=True, slots=True)
class Cylinder:
    """Cylinder along z with its centre at the frame origin.

    Attributes:
        radius: Radius, in [m].
        length: Length, in [m].
    """

    radius: float
    length: float

    def __post_init__(self) -> None:
        _positive(radius=self.radius, length=self.length)


@dataclass(frozen=True, slots=True)
class MeshShape:
    """Convex hull of a triangle mesh.

    Attributes:
        file: STL, OBJ, PLY, OFF, COLLADA or glTF file.
        scale: Factors along x, y, z that convert the units of the file to metres.
    """

    file: Path
    scale: Vector3 = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        for factor in self.scale:
            _positive(scale=factor)


Shape = Sphere | Box | Capsule | Cylinder | MeshShape


@dataclass(frozen=True, slots=True)
class Ground:
    """Horizontal ground: a box of 1 km x 1 km with a thickness of 10 m.

    Attributes:
        height: Height of its upper face, in [m].
        friction: Coefficient of Coulomb friction, or None for the value of the scene.
        restitution: Coefficient of restitution, or None for the value of the scene.
    """

    height: float = 0.0
    friction: float | None = None
    restitution: float | None = None

    def __post_init__(self) -> None:
        _near("height", (self.height,))
        _check_surface(self.friction, self.restitution)


@dataclass(frozen=True, slots=True)
class SceneObject:
    """Fixed or free object in the scene.

    Attributes:
        name: Name, different from all link names.
        shape: Shape with uniform density.
        pose: Initial pose in the world frame.
        mass: Mass, in [kg]; 0 for a fixed body.
        velocity: Initial velocity of the frame origin, world axes, in [m/s].
        angular_velocity: Initial angular velocity, world axes, in [rad/s].
        friction: Coefficient of Coulomb friction, or None for the value of the scene.
        restitution: Coefficient of restitution, or None for the value of the scene.
    """

    name: str
    shape: Shape
    pose: Pose = IDENTITY
    mass: float = 0.0
    velocity: Vector3 = (0.0, 0.0, 0.0)
    angular_velocity: Vector3 = (0.0, 0.0, 0.0)
    friction: float | None = None
    restitution: float | None = None

    def __post_init__(self) -> None:
        _finite("rpy", self.pose.rpy)
        for label, values in (
            ("position", self.pose.position),
            ("velocity", self.velocity),
            ("angular_velocity", self.angular_velocity),
        ):
            _near(label, values)
        if not (math.isfinite(self.mass) and self.mass >= 0.0):
            raise InputError(f"mass must be 0 or a positive number in kg, not {self.mass!r}")
        if not self.mass and any((*self.velocity, *self.angular_velocity)):
            raise InputError("a fixed body (mass 0) cannot have a velocity; set its mass")
        _check_surface(self.friction, self.restitution)

    @property
    def moves(self) -> bool:
        """Whether the object is free to move, that is, has a mass."""
        return self.mass > 0.0


@dataclass(frozen=True, slots=True)
class LinkShape:
    """Additional collision shape of a link.

    Attributes:
        shape: The shape.
        pose: Pose in the link frame.
        friction: Coefficient of Coulomb friction, or None for the value of the scene.
        restitution: Coefficient of restitution, or None for the value of the scene.
    """

    link: str
    shape: Shape
    pose: Pose = IDENTITY
    friction: float | None = None
    restitution: float | None = None

    def __post_init__(self) -> None:
        _near("position", self.pose.position)
        _finite("rpy", self.pose.rpy)
        _check_surface(self.friction, self.restitution)


@dataclass(frozen=True, slots=True)
class Scene:
    """Ground and objects around a robot, and the collision shapes of its links.

    Attributes:
        ground: The ground, or None.
        friction: Default coefficient of Coulomb friction of all bodies.
        restitution: Default coefficient of restitution of all bodies, from 0 (inelastic) to 1
            (elastic).
        friction_law: `pyramid` is the friction pyramid of DART. It limits the friction to mu N
            along
            each of two axes (world x and y on horizontal ground). It is exact along these axes and
            up to 41 % too large between them. `cone` is Coulomb's law in every direction. With
            `cone`, steps take 1.3 times as long for single bodies on the ground, 7 times for a
            grasped box, and 10 to 25 times for stacks.
        links: Collision shapes of links: convex hulls of their collision meshes (`meshes`),
            capsules from joint to joint (`capsules`), or only `link_shapes` (`none`).
        capsule_radius: Radius of these capsules, in [m].
        link_shapes: Additional collision shapes of links.
        mesh_folder: Folder of the link meshes, to which relative URIs refer.
        mesh_roots: Folders and files in which meshes are allowed; see `mesh_files.lies_in`
            (default: no restriction).
        self_collision: Whether links of the same robot collide. Links that are connected by a joint
            never collide. Links of different robots always collide.
        ignored: Pairs of links or objects that do not collide.
        reported: Names of links and objects whose contact forces are reported.
    """

    ground: Ground | None = None
    objects: tuple[SceneObject, ...] = ()
    friction: float = 1.0
    restitution: float = 0.0
    friction_law: FrictionLaw = "pyramid"
    links: LinkGeometry = "meshes"
    capsule_radius: float = 0.02
    link_shapes: tuple[LinkShape, ...] = ()
    mesh_folder: Path | None = None
    mesh_roots: tuple[Path, ...] | None = field(default=None, compare=False)
    self_collision: bool = False
    ignored: tuple[tuple[str, str], ...] = ()
    reported: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _check_surface(self.friction, self.restitution)
        _positive(capsule_radius=self.capsule_radius)

    @property
    def moving_objects(self) -> tuple[SceneObject, ...]:
        """The objects that are free to move, in order."""
        return tuple(item for item in self.objects if item.moves)


def _positive(**numbers: float) -> None:
    for name, value in numbers.items():
        if not 0.0 < value <= MAX_DISTANCE:
            limit = f"at most {MAX_DISTANCE:g}" if value > 0.0 else "above 0"
            raise InputError(f"{name} must be {limit}, not {value!r}")


def _finite(label: str, values: Iterable[float]) -> None:
    for value in values:
        if not math.isfinite(value):
            raise InputError(f"{label} must be finite, not {value!r}")


def _near(label: str, values: Iterable[float]) -> None:
    for value in values:
        if not abs(value) <= MAX_DISTANCE:
            raise InputError(f"{label} must be within {MAX_DISTANCE:g} of 0, not {value!r}")


def _check_surface(friction: float | None, restitution: float | None) -> None:
    if friction is not None and not (math.isfinite(friction) and friction >= 0.0):
        raise InputError(f"friction must be 0 or above, not {friction!r}")
    if restitution is not None and not 0.0 <= restitution <= 1.0:
        raise InputError(f"restitution must be within 0 and 1, not {restitution!r}")
