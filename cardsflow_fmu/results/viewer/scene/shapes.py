"""Shapes of a scene in world coordinates, independent of the viewer.

A shape has the same name in all frames. A list of points defines its position, so that the points
of all frames describe its motion.
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
    """Shape of a scene.

    Attributes:
        group: Group of shapes that are shown and hidden together; one of GROUPS.
        key: Name that is unique in the group and the same in all frames; may be empty.
        colour: Red, green and blue, from 0 to 255.
        opacity: Opacity, from 0 to 1.
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
        """Points that define the position of the shape, shape (p, 3), in [m]."""


@dataclass(frozen=True, eq=False)
class _Path(Shape):
    """Shape along a path.

    Attributes:
        path: Points of the path, shape (p, 3), in [m].
        radius: Radius, in [m].
    """

    path: FloatArray
    radius: float

    @property
    def points(self) -> FloatArray:
        """Points of the path."""
        return self.path


@dataclass(frozen=True, eq=False)
class Line(_Path):
    """Line with round cross-section through the points of the path."""


@dataclass(frozen=True, eq=False)
class Trail(_Path):
    """Spheres at the points of the path; the path grows from frame to frame."""


@dataclass(frozen=True, eq=False)
class _Segment(Shape):
    """Shape between two points.

    Attributes:
        start, end: The points, shape (3,), in [m].
        radius: Radius, in [m].
    """

    start: FloatArray
    end: FloatArray
    radius: float

    @property
    def points(self) -> FloatArray:
        """Start and end."""
        return np.stack([self.start, self.end])


@dataclass(frozen=True, eq=False)
class Arrow(_Segment):
    """Arrow with its tip at the end; invisible if its length is zero."""


@dataclass(frozen=True, eq=False)
class Capsule(_Segment):
    """Cylinder with hemispheres at its ends."""


@dataclass(frozen=True, eq=False)
class Cylinder(_Segment):
    """Cylinder with flat ends."""


@dataclass(frozen=True, eq=False)
class Sphere(Shape):
    """Sphere.

    Attributes:
        centre: Centre, shape (3,), in [m].
        radius: Radius, in [m].
    """

    centre: FloatArray
    radius: float

    @property
    def points(self) -> FloatArray:
        """Centre."""
        return self.centre[np.newaxis]


@dataclass(frozen=True, eq=False)
class Frame(Shape):
    """Coordinate frame: x axis red, y axis green, z axis blue.

    Attributes:
        T: Pose in the world, shape (4, 4).
        length: Length of an axis, in [m].
        radius: Radius of an axis, in [m].
    """

    T: FloatArray
    length: float
    radius: float

    @property
    def points(self) -> FloatArray:
        """Origin and tips of the three axes."""
        return _origin_and_tips(self.T, self.length)


@dataclass(frozen=True, eq=False)
class Triangles:
    """Triangle mesh.

    Attributes:
        vertices: Positions of the vertices, shape (v, 3), in [m].
        faces: Indices of the three vertices of each triangle, shape (t, 3).
        colour: Red, green and blue; None if the file does not specify it.
    """

    vertices: FloatArray
    faces: NDArray[np.int64]
    colour: Colour | None = None


@dataclass(frozen=True, eq=False)
class MeshShape(Shape):
    """Rigid mesh.

    Attributes:
        T: Pose in the world, shape (4, 4).
        triangles: Mesh in its local frame.
        lever: Distance between the origin and the points on the axes, in [m].
    """

    T: FloatArray
    triangles: Triangles
    lever: float = 1.0

    @property
    def points(self) -> FloatArray:
        """Origin, and one point on each of the three axes."""
        return _origin_and_tips(self.T, self.lever)


@dataclass(frozen=True, eq=False)
class Label(Shape):
    """Text with a name and a number.

    Attributes:
        position: Position, shape (3,), in [m].
        title: Name of the number.
        unit: Unit of the number, such as `rad`.
    """

    position: FloatArray
    title: str
    value: float
    unit: str = field(default="")

    @property
    def points(self) -> FloatArray:
        """Position."""
        return self.position[np.newaxis]

    @property
    def text(self) -> str:
        """Text, such as `elbow: 1.424`."""
        return f"{self.title}: {self.value:.3f}"


def _origin_and_tips(T: FloatArray, length: float) -> FloatArray:
    origin = T[:3, 3]
    points: FloatArray = np.vstack([origin, origin + length * T[:3, :3].T])
    return points
