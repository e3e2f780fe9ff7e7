"""The shapes of a scene: plain records in world coordinates, independent of any viewer.

A shape keeps its name from frame to frame, and a list of points defines its position: a motion is
fully described by these points.
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
"""All groups, in the order of their switches."""

HIDDEN_AT_FIRST = (LINK_FRAMES, JOINT_VALUES)


@dataclass(frozen=True, eq=False)
class Shape(ABC):
    """Something to draw.

    Attributes:
        group: The group that it is shown and hidden with; one of GROUPS.
        key: Unique in its group, and the same in every frame; may be empty.
        colour: Red, green and blue, 0 to 255.
        opacity: 0 to 1.
    """

    group: str
    key: str
    colour: Colour
    opacity: float = field(default=1.0, kw_only=True)

    @property
    def name(self) -> str:
        """Group and key, unique in a scene."""
        return f"{self.group}/{self.key}" if self.key else self.group

    @property
    @abstractmethod
    def points(self) -> FloatArray:
        """The points that define its position, shape (p, 3), in [m]."""


@dataclass(frozen=True, eq=False)
class _Path(Shape):
    """Something round along a path.

    Attributes:
        path: Shape (p, 3), in [m].
        radius: In [m].
    """

    path: FloatArray
    radius: float

    @property
    def points(self) -> FloatArray:
        """The path."""
        return self.path


@dataclass(frozen=True, eq=False)
class Line(_Path):
    """A round line through the points of its path."""


@dataclass(frozen=True, eq=False)
class Trail(_Path):
    """Spheres about the points of its path; a later frame's trail begins with an earlier one's."""


@dataclass(frozen=True, eq=False)
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


@dataclass(frozen=True, eq=False)
class Arrow(_Between):
    """An arrow whose tip is at the end; invisible where it has no length."""


@dataclass(frozen=True, eq=False)
class Capsule(_Between):
    """A cylinder with round caps about its ends."""


@dataclass(frozen=True, eq=False)
class Cylinder(_Between):
    """A cylinder with flat caps."""


@dataclass(frozen=True, eq=False)
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


@dataclass(frozen=True, eq=False)
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
        colour: Red, green and blue; None where its file does not say.
    """

    vertices: FloatArray
    faces: NDArray[np.int64]
    colour: Colour | None = None


@dataclass(frozen=True, eq=False)
class MeshShape(Shape):
    """A rigid mesh.

    Attributes:
        T: Its pose in the world, shape (4, 4).
        triangles: In its own frame.
        lever: Distance of the axes' points from the origin, in [m].
    """

    T: FloatArray
    triangles: Triangles
    lever: float = 1.0

    @property
    def points(self) -> FloatArray:
        """The origin and a point on each of the three axes."""
        return _origin_and_tips(self.T, self.lever)


@dataclass(frozen=True, eq=False)
class Label(Shape):
    """A named number.

    Attributes:
        position: Shape (3,), in [m].
        title: Its name.
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
        """The text, such as `elbow: 1.424`."""
        return f"{self.title}: {self.value:.3f}"


def _origin_and_tips(T: FloatArray, length: float) -> FloatArray:
    origin = T[:3, 3]
    points: FloatArray = np.vstack([origin, origin + length * T[:3, :3].T])
    return points
