"""What a viewer draws: plain records, in world coordinates, that know no viewer.

A shape keeps its name from frame to frame, and its place is told by a list of points: whoever draws
or stores a motion needs those points only.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cardsflow_fmu.utils.arrays import FloatArray

Colour = tuple[int, int, int]

LINKS = "links"
OBJECTS = "objects"
GROUND = "ground"
MUSCLES = "muscles"
VIA_POINTS = "via points"
FORCES = "forces"
JOINT_FRAMES = "joint frames"
LINK_FRAMES = "link frames"
JOINT_VALUES = "joint values"
WRAP_SURFACES = "wrap surfaces"
CONTACTS = "contacts"
TRAIL = "trail"
REFERENCE = "reference"

GROUPS = (
    LINKS,
    OBJECTS,
    GROUND,
    MUSCLES,
    VIA_POINTS,
    FORCES,
    JOINT_FRAMES,
    LINK_FRAMES,
    JOINT_VALUES,
    WRAP_SURFACES,
    CONTACTS,
    TRAIL,
    REFERENCE,
)
"""What can be shown and hidden, in the order of the switches."""

HIDDEN_AT_FIRST = (LINK_FRAMES,)


@dataclass(frozen=True, eq=False, kw_only=True)
class Shape(ABC):
    """Something to draw.

    Attributes:
        name: Unique in its scene, and the same in every frame.
        group: What it is shown and hidden with; one of GROUPS.
        colour: Red, green and blue, 0 to 255.
        opacity: 1 for a body that hides what is behind it.
    """

    name: str
    group: str
    colour: Colour
    opacity: float = 1.0

    @property
    @abstractmethod
    def points(self) -> FloatArray:
        """All points that say where it is, shape (p, 3), in [m]."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Line(Shape):
    """A round line.

    Attributes:
        path: Its corners, shape (p, 3), in [m].
        radius: In [m].
    """

    path: FloatArray
    radius: float

    @property
    def points(self) -> FloatArray:
        """The corners."""
        return self.path


@dataclass(frozen=True, eq=False, kw_only=True)
class Trail(Shape):
    """Spheres along a way; a later frame's trail begins with an earlier one's.

    Attributes:
        path: Centres of the spheres, shape (p, 3), in [m].
        radius: Of every sphere, in [m].
    """

    path: FloatArray
    radius: float

    @property
    def points(self) -> FloatArray:
        """The centres."""
        return self.path


@dataclass(frozen=True, eq=False, kw_only=True)
class _Between(Shape):
    """Something round from one point to another.

    Attributes:
        start, end: Its ends, shape (3,), in [m].
        radius: In [m].
    """

    start: FloatArray
    end: FloatArray
    radius: float

    @property
    def points(self) -> FloatArray:
        """The two ends."""
        return np.stack([self.start, self.end])


@dataclass(frozen=True, eq=False, kw_only=True)
class Arrow(_Between):
    """An arrow whose tip is at the end; invisible where it has no length."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Capsule(_Between):
    """A cylinder with round caps about its ends."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Cylinder(_Between):
    """A cylinder with flat caps."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Sphere(Shape):
    """A sphere.

    Attributes:
        centre: Shape (3,), in [m].
        radius: In [m].
    """

    centre: FloatArray
    radius: float

    @property
    def points(self) -> FloatArray:
        """The centre."""
        return self.centre[np.newaxis]


@dataclass(frozen=True, eq=False, kw_only=True)
class Frame(Shape):
    """Three axes: x red, y green, z blue.

    Attributes:
        T: Its pose in the world, shape (4, 4).
        length: Of an axis, in [m].
        radius: Of an axis, in [m].
    """

    T: FloatArray
    length: float
    radius: float

    @property
    def points(self) -> FloatArray:
        """The origin and the tips of the three axes."""
        return _origin_and_tips(self.T, self.length)


@dataclass(frozen=True, eq=False)
class Triangles:
    """A surface.

    Attributes:
        vertices: Shape (v, 3), in [m].
        faces: Three vertices each, shape (t, 3).
    """

    vertices: FloatArray
    faces: NDArray[np.int64]


@dataclass(frozen=True, eq=False, kw_only=True)
class MeshShape(Shape):
    """A rigid mesh.

    Attributes:
        T: Its pose in the world, shape (4, 4).
        triangles: In its own frame.
        lever: How far from the origin `points` marks the axes, in [m].
    """

    T: FloatArray
    triangles: Triangles
    lever: float = 1.0

    @property
    def points(self) -> FloatArray:
        """The origin and a point on each of the three axes."""
        return _origin_and_tips(self.T, self.lever)


@dataclass(frozen=True, eq=False, kw_only=True)
class Label(Shape):
    """A named number.

    Attributes:
        position: Shape (3,), in [m].
        title: What it is.
        value: In its unit.
        unit: Such as `rad`.
    """

    position: FloatArray
    title: str
    value: float
    unit: str = field(default="")

    @property
    def points(self) -> FloatArray:
        """The position."""
        return self.position[np.newaxis]

    @property
    def text(self) -> str:
        """What to write: `elbow: 1.424`."""
        return f"{self.title}: {self.value:.3f}"


def _origin_and_tips(T: FloatArray, length: float) -> FloatArray:
    origin = T[:3, 3]
    points: FloatArray = np.vstack([origin, origin + length * T[:3, :3].T])
    return points
