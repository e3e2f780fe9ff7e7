"""Shapes of bodies: exact mass properties, meshes, vertices, edges and faces. Lengths in cm."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..maths import apply, frame

STEEL = 7.85e-3
"""Density of steel, Fusion's default material, in [kg/cm³]."""


@dataclass(frozen=True)
class Mass:
    """Mass properties in some frame.

    Attributes:
        mass: In [kg].
        com: Centre of mass, shape (3,), in [cm].
        inertia: Inertia matrix about the centre of mass, shape (3, 3), in [kg·cm²].
        volume: In [cm³].
    """

    mass: float
    com: np.ndarray
    inertia: np.ndarray
    volume: float = 0.0

    def moved(self, T: np.ndarray) -> Mass:
        """Return the mass properties transformed by T."""
        R = T[:3, :3]
        return replace(self, com=apply(T, self.com), inertia=R @ self.inertia @ R.T)

    def about_origin(self) -> np.ndarray:
        """Return the inertia matrix about the origin of the frame, in [kg·cm²]."""
        r = self.com
        return self.inertia + self.mass * (r @ r * np.eye(3) - np.outer(r, r))

    def with_mass(self, mass: float) -> Mass:
        """Return the mass properties of the same shape with another mass."""
        factor = mass / self.mass if self.mass else 0.0
        return replace(self, mass=mass, inertia=factor * self.inertia)


NOTHING = Mass(0.0, np.zeros(3), np.zeros((3, 3)))


def total(parts: list[Mass]) -> Mass:
    """Return the total mass properties of several bodies by the parallel-axis theorem."""
    mass = sum(p.mass for p in parts)
    volume = sum(p.volume for p in parts)
    if mass == 0.0:
        return replace(NOTHING, volume=volume)
    if len(parts) == 1:
        return parts[0]
    com = sum(p.mass * p.com for p in parts) / mass
    inertia = np.zeros((3, 3))
    for p in parts:
        r = p.com - com
        inertia = inertia + p.inertia + p.mass * (r @ r * np.eye(3) - np.outer(r, r))
    return Mass(mass, com, inertia, volume)


@dataclass(frozen=True)
class EdgeShape:
    """A straight edge (centre is the start, axis the direction, radius 0), a circle or an arc.

    Attributes:
        centre, axis, radius, length: In [cm].
        sweep: Angle of an arc, in [rad]; 0 for a whole circle.
    """

    centre: np.ndarray
    axis: np.ndarray
    radius: float = 0.0
    length: float = 0.0
    sweep: float = 0.0


@dataclass(frozen=True)
class FaceShape:
    """A face.

    Attributes:
        kind: `plane`, `cylinder`, `sphere` or `torus`.
        origin: A point of the plane, of the axis (middle of the cylinder), or the centre.
        axis: Normal of the plane, or axis; unit.
        radius: Of cylinder or sphere; the major one of a torus.
        minor: The minor radius of a torus.
        length: Of the cylinder.
    """

    kind: str
    origin: np.ndarray
    axis: np.ndarray
    radius: float = 0.0
    minor: float = 0.0
    length: float = 0.0


@dataclass(frozen=True)
class Shape(ABC):
    """A shape in the frame of its component.

    Attributes:
        T: Pose of the shape, shape (4, 4), in [cm].
        density: In [kg/cm³].
    """

    T: np.ndarray
    density: float = STEEL

    @abstractmethod
    def own_mass(self, density: float) -> Mass:
        """Return the mass properties in the frame of the shape."""

    @abstractmethod
    def own_mesh(self, segments: int) -> tuple[np.ndarray, np.ndarray]:
        """Return nodes (n, 3) in the frame of the shape and triangles (m, 3)."""

    @abstractmethod
    def own_parts(self) -> tuple[list, list[EdgeShape], list[FaceShape]]:
        """Return vertices, edges and faces in the frame of the shape."""

    @abstractmethod
    def own_reach(self, axes: np.ndarray) -> np.ndarray:
        """Return the extents of the shape from its centre.

        Args:
            axes: Unit directions in the frame of the shape, shape (n, 3).

        Returns:
            Distances, shape (n,), in [cm].
        """

    def bounds(self, T: np.ndarray) -> np.ndarray:
        """Return the exact minimum and maximum corner in a frame, shape (2, 3), in [cm].

        Args:
            T: Pose of the component in this frame.
        """
        T = T @ self.T
        reach = self.own_reach(T[:3, :3])  # rows are the axes of the frame in the shape frame
        return np.array([T[:3, 3] - reach, T[:3, 3] + reach])

    def mass(self, density: float | None = None) -> Mass:
        """Return the mass properties in the frame of the component."""
        return self.own_mass(self.density if density is None else density).moved(self.T)

    def mesh(self, segments: int) -> tuple[np.ndarray, np.ndarray]:
        """Return nodes in the frame of the component, and triangles."""
        nodes, triangles = self.own_mesh(segments)
        return nodes @ self.T[:3, :3].T + self.T[:3, 3], triangles

    def parts(self) -> tuple[list, list[EdgeShape], list[FaceShape]]:
        """Return vertices, edges and faces in the frame of the component."""
        R = self.T[:3, :3]
        vertices, edges, faces = self.own_parts()
        return (
            [apply(self.T, v) for v in vertices],
            [replace(e, centre=apply(self.T, e.centre), axis=R @ e.axis) for e in edges],
            [replace(f, origin=apply(self.T, f.origin), axis=R @ f.axis) for f in faces],
        )


@dataclass(frozen=True)
class Box(Shape):
    """A box centred at the origin of its frame. `size`: lengths along x, y, z, in [cm]."""

    size: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def own_mass(self, density: float) -> Mass:
        a, b, c = self.size
        m = density * a * b * c
        moments = np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) * m / 12.0
        return Mass(m, np.zeros(3), moments, a * b * c)

    def own_reach(self, axes: np.ndarray) -> np.ndarray:
        return np.abs(axes) @ np.array(self.size) / 2.0

    def own_mesh(self, segments: int) -> tuple[np.ndarray, np.ndarray]:
        return _corners(self.size), _BOX

    def own_parts(self) -> tuple[list, list[EdgeShape], list[FaceShape]]:
        corners = _corners(self.size)
        edges = [
            EdgeShape(corners[i], _unit(corners[j] - corners[i]), 0.0, self.size[k])
            for k in range(3)
            for i in range(8)
            for j in [i ^ (4 >> k)]
            if i < j
        ]
        faces = [
            FaceShape("plane", s * self.size[k] / 2.0 * np.eye(3)[k], s * np.eye(3)[k])
            for k in range(3)
            for s in (-1.0, 1.0)
        ]
        return list(corners), edges, faces


@dataclass(frozen=True)
class Cylinder(Shape):
    """A cylinder about the z axis of its frame, from -height/2 to height/2."""

    radius: float = 1.0
    height: float = 1.0

    def own_mass(self, density: float) -> Mass:
        r, h = self.radius, self.height
        volume = math.pi * r * r * h
        m = density * volume
        across = m * (3.0 * r * r + h * h) / 12.0
        return Mass(m, np.zeros(3), np.diag([across, across, m * r * r / 2.0]), volume)

    def own_reach(self, axes: np.ndarray) -> np.ndarray:
        return self.height / 2.0 * np.abs(axes[:, 2]) + self.radius * _across(axes)

    def own_mesh(self, segments: int) -> tuple[np.ndarray, np.ndarray]:
        angles = 2.0 * math.pi * np.arange(segments) / segments
        ring = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(segments)]) * self.radius
        up = np.array([0.0, 0.0, self.height / 2.0])
        nodes = np.vstack([ring - up, ring + up, -up, up])
        k = np.arange(segments)
        n = (k + 1) % segments
        low, high = np.full(segments, 2 * segments), np.full(segments, 2 * segments + 1)
        sides = [(k, n, n + segments), (k, n + segments, k + segments)]
        ends = [(n, k, low), (k + segments, n + segments, high)]
        return nodes, np.vstack([np.column_stack(t) for t in sides + ends])

    def own_parts(self) -> tuple[list, list[EdgeShape], list[FaceShape]]:
        r, z, up = self.radius, np.array([0.0, 0.0, 1.0]), self.height / 2.0
        vertices = [s * up * z + np.array([r, 0.0, 0.0]) for s in (-1.0, 1.0)]
        edges = [EdgeShape(s * up * z, s * z, r, 2.0 * math.pi * r) for s in (-1.0, 1.0)]
        faces = [FaceShape("cylinder", np.zeros(3), z, r, 0.0, self.height)]
        faces += [FaceShape("plane", s * up * z, s * z) for s in (-1.0, 1.0)]
        return vertices, edges, faces


@dataclass(frozen=True)
class Sphere(Shape):
    """A sphere centred at the origin of its frame."""

    radius: float = 1.0

    def own_mass(self, density: float) -> Mass:
        volume = 4.0 / 3.0 * math.pi * self.radius**3
        m = density * volume
        return Mass(m, np.zeros(3), np.eye(3) * 0.4 * m * self.radius**2, volume)

    def own_reach(self, axes: np.ndarray) -> np.ndarray:
        return np.full(len(axes), self.radius)

    def own_mesh(self, segments: int) -> tuple[np.ndarray, np.ndarray]:
        return _revolved(self.radius, segments)

    def own_parts(self) -> tuple[list, list[EdgeShape], list[FaceShape]]:
        z = np.array([0.0, 0.0, 1.0])
        return [], [], [FaceShape("sphere", np.zeros(3), z, self.radius)]


@dataclass(frozen=True)
class Torus(Shape):
    """A torus about the z axis of its frame."""

    major: float = 2.0
    minor: float = 0.5

    def own_mass(self, density: float) -> Mass:
        R, r = self.major, self.minor
        volume = 2.0 * math.pi**2 * R * r * r
        m = density * volume
        across, along = m * (0.5 * R * R + 0.625 * r * r), m * (R * R + 0.75 * r * r)
        return Mass(m, np.zeros(3), np.diag([across, across, along]), volume)

    def own_reach(self, axes: np.ndarray) -> np.ndarray:
        return self.major * _across(axes) + self.minor

    def own_mesh(self, segments: int) -> tuple[np.ndarray, np.ndarray]:
        u = 2.0 * math.pi * np.arange(segments) / segments
        a, b = np.meshgrid(u, u, indexing="ij")
        along = self.major + self.minor * np.cos(b)
        nodes = np.stack(
            [along * np.cos(a), along * np.sin(a), self.minor * np.sin(b)], axis=-1
        ).reshape(-1, 3)
        i, j = (k.ravel() for k in np.meshgrid(range(segments), range(segments), indexing="ij"))
        i2, j2 = (i + 1) % segments, (j + 1) % segments
        p, q, r, s = i * segments + j, i2 * segments + j, i2 * segments + j2, i * segments + j2
        return nodes, np.vstack([np.column_stack([p, q, r]), np.column_stack([p, r, s])])

    def own_parts(self) -> tuple[list, list[EdgeShape], list[FaceShape]]:
        z = np.array([0.0, 0.0, 1.0])
        return [], [], [FaceShape("torus", np.zeros(3), z, self.major, self.minor)]


@dataclass(frozen=True)
class Explicit(Box):
    """A box with given mass properties, which are independent of its size.

    Attributes:
        kilograms: Mass, in [kg].
        com: Centre of mass in the frame of the shape, in [cm].
        inertia: Inertia matrix about the centre of mass, in [kg·cm²], tensor signs.
    """

    kilograms: float = 1.0
    com: tuple[float, float, float] = (0.0, 0.0, 0.0)
    inertia: Any = None

    def own_mass(self, density: float) -> Mass:
        a, b, c = self.size
        inertia = np.zeros((3, 3)) if self.inertia is None else np.array(self.inertia, dtype=float)
        return Mass(self.kilograms, np.array(self.com, dtype=float), inertia, a * b * c)


def at(origin: Any = (0.0, 0.0, 0.0), z: Any = (0.0, 0.0, 1.0), x: Any = None) -> np.ndarray:
    """Return the pose of a shape from its origin in [cm], z axis and approximate x axis."""
    return frame(origin, z, x)


def _across(axes: np.ndarray) -> np.ndarray:
    """Return the length of unit vectors perpendicular to z."""
    return np.linalg.norm(axes[:, :2], axis=1)


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v)


def _corners(size: Any) -> np.ndarray:
    signs = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)]) - 0.5
    return signs * np.asarray(size, dtype=float)


_BOX = np.array(
    [
        *[(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5)],
        *[(0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6)],
        *[(0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)],
    ]
)


def _revolved(radius: float, segments: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a sphere as rings of nodes between two poles."""
    rings = max(segments // 2, 2)
    polar = math.pi * np.arange(1, rings) / rings
    around = 2.0 * math.pi * np.arange(segments) / segments
    a, b = np.meshgrid(polar, around, indexing="ij")
    ball = np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)], axis=-1)
    nodes = radius * np.vstack([ball.reshape(-1, 3), [[0, 0, 1]], [[0, 0, -1]]])
    top, bottom = len(nodes) - 2, len(nodes) - 1
    triangles = []
    for k in range(segments):
        n = (k + 1) % segments
        triangles.append((top, k, n))
        for i in range(rings - 2):
            p, q = i * segments, (i + 1) * segments
            triangles += [(p + k, q + k, q + n), (p + k, q + n, p + n)]
        last = (rings - 2) * segments
        triangles.append((last + k, bottom, last + n))
    return nodes, np.array(triangles)
