"""Shapes of the environment: the ground, and objects at rest and in motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache

import numpy as np

from addin_sdfusion.robot import Pose
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.core.frames import transform
from sim_dart.scene import Box, Capsule, Cylinder, MeshShape, Scene, SceneObject, Sphere

from . import colours
from . import shapes as s
from .meshes import read_triangles
from .shapes import Triangles
from .solids import box_triangles

_WIDE = 3.0
"""Edge length of the drawn ground, as multiple of the diagonal of the box above it."""


class Environment:
    """Objects and ground in all frames.

    Args:
        moved: Poses of moving objects, shape (K, 4, 4), by name. Other objects do not move.

    Attributes:
        positions: Position of every object, shape (K, 3) or (1, 3), by name.
        floor: Height of the ground, in [m]; None without ground.
    """

    def __init__(self, world: Scene | None, moved: Mapping[str, FloatArray]) -> None:
        self._objects = () if world is None else world.objects
        self._poses = {
            item.name: moved.get(item.name, transform(item.pose)[np.newaxis])
            for item in self._objects
        }
        self._surfaces = {item.name: _triangles(item) for item in self._objects}
        self.positions = {name: T[:, :3, 3] for name, T in self._poses.items()}
        self.floor = None if world is None or world.ground is None else world.ground.height

    def shapes(self, k: int, box: tuple[FloatArray, FloatArray]) -> Iterator[s.Shape]:
        """Return the shapes of frame k.

        Args:
            box: Two corners of the box above the ground, in [m].
        """
        for item in self._objects:
            poses = self._poses[item.name]
            yield self._shape(item, poses[min(k, len(poses) - 1)])
        if self.floor is not None:
            yield _ground(self.floor, box)

    def _shape(self, item: SceneObject, T: FloatArray) -> s.Shape:
        shared = s.OBJECTS, item.name, colours.OBJECT if item.moves else colours.STILL
        surface, middle = self._surfaces[item.name], T[:3, 3]
        if surface is not None:
            return s.MeshShape(*shared, T, surface)
        if isinstance(item.shape, Capsule | Cylinder):
            half = 0.5 * item.shape.length * T[:3, 2]
            form = s.Capsule if isinstance(item.shape, Capsule) else s.Cylinder
            return form(*shared, middle - half, middle + half, item.shape.radius)
        # a small sphere replaces an unreadable surface
        radius = item.shape.radius if isinstance(item.shape, Sphere) else 0.01
        return s.Sphere(*shared, middle, radius)


@lru_cache(maxsize=64)
def _triangles(item: SceneObject) -> Triangles | None:
    """Return the surface of a box or mesh; None for other shapes and unreadable meshes."""
    if isinstance(item.shape, Box):
        return box_triangles(0.5 * np.array(item.shape.size))
    if not isinstance(item.shape, MeshShape):
        return None
    mesh = read_triangles(item.shape.file)
    return mesh and Triangles(mesh.vertices * np.array(item.shape.scale), mesh.faces)


def _ground(height: float, box: tuple[FloatArray, FloatArray]) -> s.Shape:
    """Return a square below a box."""
    low, high = box
    middle = np.array([*(0.5 * (low + high))[:2], height])
    half = 0.5 * _WIDE * max(float(np.linalg.norm(high - low)), 1e-3)
    corners = half * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    T = transform(Pose((middle[0], middle[1], middle[2])))
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    return s.MeshShape(s.GROUND, "", colours.GROUND, T, Triangles(corners, faces))
