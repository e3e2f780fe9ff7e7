"""Collision shapes of links: shapes and hulls of the robot, capsules, and shapes of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from addin_sdfusion.robot import Link, Pose, Robot, UnknownNameError, Vector3
from addin_sdfusion.robot.mesh_files import allowed_mesh_file
from addin_sdfusion.robot.model.link_segments import link_segments
from addin_sdfusion.robot.model.rotations import add, scale, subtract, z_axis_rpy
from sim_dart.scene import Box, Capsule, Cylinder, LinkShape, MeshShape, Scene, Sphere


def link_shapes(robot: Robot, scene: Scene) -> list[LinkShape]:
    """Return the shapes of all links.

    Args:
        robot: A valid robot.
        scene: Scene with the settings for links.

    Raises:
        UnknownNameError: The link of a shape does not exist.
        InputError: A mesh is outside of the `mesh_roots` of the scene.
    """
    names = [link.name for link in robot.links]
    for shape in scene.link_shapes:
        if shape.link not in names:
            raise UnknownNameError("link", shape.link, names)
    shapes: list[LinkShape] = []
    for link in robot.links:
        if scene.links == "meshes":
            shapes += _hulls(link, scene)
        elif scene.links == "capsules":
            shapes += _capsules(robot, link, scene.capsule_radius)
    return shapes + list(scene.link_shapes)


def _hulls(link: Link, scene: Scene) -> Iterator[LinkShape]:
    for mesh in link.meshes:
        if mesh.role == "collision":
            file = allowed_mesh_file(mesh.uri, scene.mesh_folder, scene.mesh_roots)
            yield LinkShape(link.name, MeshShape(file, mesh.scale), mesh.pose)
    for shape in link.shapes:
        yield LinkShape(link.name, _KINDS[shape.kind](shape.sizes), shape.pose)


_KINDS: dict[str, Callable[[tuple[float, ...]], Box | Sphere | Cylinder]] = {
    "box": lambda sizes: Box((sizes[0], sizes[1], sizes[2])),
    "sphere": lambda sizes: Sphere(sizes[0]),
    "cylinder": lambda sizes: Cylinder(sizes[0], sizes[1]),
}


def _capsules(robot: Robot, link: Link, radius: float) -> Iterator[LinkShape]:
    """Generate capsules from the parent joint of a link to its child joints and its far end."""
    for begin, end in link_segments(robot, link):
        length = math.dist(begin, end)
        yield LinkShape(link.name, Capsule(radius, length), between(begin, end))


def between(begin: Vector3, end: Vector3) -> Pose:
    """Return the pose in the middle of two points, with the z axis from the first to the second."""
    return Pose(scale(0.5, add(begin, end)), z_axis_rpy(subtract(end, begin)))
