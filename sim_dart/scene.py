"""Description of the scene around a robot: ground, objects, and collision shapes of links.

Two bodies in contact have the smaller of their coefficients of friction and the geometric mean of
their coefficients of restitution.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from addin_sdfusion.robot import IDENTITY, InputError, Pose, Vector3

GROUND = "ground"
"""The name of the ground among the bodies of a world."""

MAX_DISTANCE = 1e6
"""In [m], [m/s], [rad/s]: no body of ours is so far, large or fast, and ODE aborts beyond 1e15."""

LinkGeometry = Literal["meshes", "capsules", "none"]
FrictionLaw = Literal["pyramid", "cone"]
FRICTION_EXCESS: dict[FrictionLaw, float] = {"pyramid": math.sqrt(2.0) - 1.0, "cone": 0.0}
"""By which part of Coulomb's friction a law is too strong, at most."""


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere about its frame's origin.

    Attributes:
        radius: In [m].
    """

    radius: float

    def __post_init__(self) -> None:
        _positive(radius=self.radius)


@dataclass(frozen=True, slots=True)
class Box:
    """A box about its frame's origin.

    Attributes:
        size: Edges along x, y, z, in [m].
    """

    size: Vector3

    def __post_init__(self) -> None:
        for edge in self.size:
            _positive(size=edge)


@dataclass(frozen=True, slots=True)
class Capsule:
    """A cylinder along z with half spheres at its ends.

    Attributes:
        radius: In [m].
        length: Of the cylinder alone, in [m].
    """

    radius: float
    length: float

    def __post_init__(self) -> None:
        _positive(radius=self.radius, length=self.length)


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along z, its middle at its frame's origin.

    Attributes:
        radius: In [m].
        length: In [m].
    """

    radius: float
    length: float

    def __post_init__(self) -> None:
        _positive(radius=self.radius, length=self.length)


@dataclass(frozen=True, slots=True)
class MeshShape:
    """The convex hull of a triangle mesh.

    Attributes:
        file: STL, OBJ, PLY, OFF, COLLADA or glTF.
        scale: Factors along x, y, z that make metres of the file's units.
    """

    file: Path
    scale: Vector3 = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        for factor in self.scale:
            _positive(scale=factor)


Shape = Sphere | Box | Capsule | Cylinder | MeshShape


@dataclass(frozen=True, slots=True)
class Ground:
    """A level floor that has no ends: 1 km square, 10 m thick.

    Attributes:
        height: Of its upper face, in [m].
        friction: Coefficient of Coulomb friction; the scene's when None.
        restitution: The scene's when None.
    """

    height: float = 0.0
    friction: float | None = None
    restitution: float | None = None

    def __post_init__(self) -> None:
        _near("height", (self.height,))
        _check_surface(self.friction, self.restitution)


@dataclass(frozen=True, slots=True)
class SceneObject:
    """A body next to the robot, free to move or fixed.

    Attributes:
        name: Its name, unlike that of any link.
        shape: Its form; its mass is spread evenly over it.
        pose: Of its frame in the world, at the start.
        mass: In [kg]; 0 for a fixed body.
        velocity: Of its frame's origin at the start, world axes, in [m/s].
        angular_velocity: Angular velocity at the start, world axes, in [rad/s].
        friction: Coefficient of Coulomb friction; the scene's when None.
        restitution: The scene's when None.
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
        for what, values in (
            ("position", self.pose.position),
            ("velocity", self.velocity),
            ("angular_velocity", self.angular_velocity),
        ):
            _near(what, values)
        if not (math.isfinite(self.mass) and self.mass >= 0.0):
            raise InputError(f"mass must be 0 or a positive number in kg, not {self.mass!r}")
        if not self.mass and any((*self.velocity, *self.angular_velocity)):
            raise InputError("a fixed body (mass 0) has no velocity; give it a mass")
        _check_surface(self.friction, self.restitution)

    @property
    def moves(self) -> bool:
        """Whether it has a mass, and so moves."""
        return self.mass > 0.0


@dataclass(frozen=True, slots=True)
class LinkShape:
    """A collision shape of a link, beside those of its own meshes.

    Attributes:
        link: Name of the link.
        shape: The form.
        pose: In the link's frame.
        friction: Coefficient of Coulomb friction; the scene's when None.
        restitution: The scene's when None.
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
    """The ground and objects around a robot, and the collision shapes of its links.

    Attributes:
        ground: The floor; None for none.
        objects: Bodies next to the robot.
        friction: Coefficient of Coulomb friction of bodies without their own.
        restitution: Of bodies without their own: 0 for none, 1 for a bounce without loss.
        friction_law: `pyramid`, DART's rule: friction up to mu N along each of two axes, on level
            ground the world's x and y: exact along these, between them too strong by up to the
            root of two. `cone`: Coulomb's law in every direction; steps take 1.3 times as long with
            single bodies on the ground, 7 times with a box in a grasp, 10 to 25 times with stacks.
        links: What links collide with: the convex hulls of their collision meshes, capsules from
            their joint to the next, or only `link_shapes`.
        capsule_radius: Of such capsules, in [m].
        link_shapes: Further forms of links.
        mesh_folder: Folder of the links' meshes, which relative URIs refer to.
        mesh_roots: Folders and files that meshes may lie in; see `mesh_files.lies_in`. Anywhere
            when None.
        self_collision: Whether links of one robot collide with one another; those that a joint
            connects never do. Robots always collide with one another.
        ignored: Pairs of links or objects that pass through one another.
        reported: Links and objects whose contact forces are reported.
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
        """The objects with a mass, in order."""
        return tuple(item for item in self.objects if item.moves)


def _positive(**numbers: float) -> None:
    for name, value in numbers.items():
        if not 0.0 < value <= MAX_DISTANCE:
            limit = f"at most {MAX_DISTANCE:g}" if value > 0.0 else "above 0"
            raise InputError(f"{name} must be {limit}, not {value!r}")


def _finite(what: str, values: Iterable[float]) -> None:
    for value in values:
        if not math.isfinite(value):
            raise InputError(f"{what} must be finite, not {value!r}")


def _near(what: str, values: Iterable[float]) -> None:
    for value in values:
        if not abs(value) <= MAX_DISTANCE:
            raise InputError(f"{what} must be within {MAX_DISTANCE:g} of 0, not {value!r}")


def _check_surface(friction: float | None, restitution: float | None) -> None:
    if friction is not None and not (math.isfinite(friction) and friction >= 0.0):
        raise InputError(f"friction must be 0 or above, not {friction!r}")
    if restitution is not None and not 0.0 <= restitution <= 1.0:
        raise InputError(f"restitution must be within 0 and 1, not {restitution!r}")
