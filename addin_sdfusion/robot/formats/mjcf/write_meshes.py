"""Writer of meshes and shapes in MJCF: assets, and geoms with collisions disabled."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

from ...model.robot import Robot
from ...transforms.joint_chains import Names
from ..writing.xml_text import element, numbers
from .write_bodies import placement

GROUPS = {"visual": "2", "collision": "4"}
NO_COLLISIONS = {"contype": "0", "conaffinity": "0"}


_STL_HEAD, _STL_FACET = 84, 50
_MAX_FACETS = 200_000


def can_open_mesh(suffix: str, data: bytes) -> bool:
    """Return whether MuJoCo can open a mesh: .obj, or binary .stl with at most 200000 facets."""
    if suffix != ".stl":
        return suffix == ".obj"
    facets = int.from_bytes(data[_STL_HEAD - 4 : _STL_HEAD], "little")
    return 1 <= facets <= _MAX_FACETS and len(data) == _STL_HEAD + _STL_FACET * facets


def add_meshes(
    robot: Robot,
    files: Mapping[str, str | Path],
    assets: ElementTree.Element,
    bodies: dict[str, ElementTree.Element],
) -> None:
    """Add the meshes that have a file."""
    names = Names()
    for link in robot.links:
        for mesh in link.meshes:
            if mesh.uri not in files:
                continue
            name = names.unique(mesh.name or f"{link.name} {mesh.role}")
            file, scale = str(files[mesh.uri]), numbers(mesh.scale)
            # Links define the masses. MuJoCo rejects open meshes unless their inertia is a shell.
            element(assets, "mesh", name=name, file=file, scale=scale, inertia="shell")
            shape = {"type": "mesh", "mesh": name, "group": GROUPS[mesh.role]}
            if mesh.color is not None:
                shape["rgba"] = numbers(mesh.color)
            element(
                bodies[link.name], "geom", None, **shape, **placement(mesh.pose), **NO_COLLISIONS
            )


def add_shapes(robot: Robot, bodies: dict[str, ElementTree.Element]) -> None:
    """Add the collision shapes of links; MJCF stores half the edges and lengths."""
    for link in robot.links:
        for shape in link.shapes:
            halves = [0.5 * size for size in shape.sizes]
            if shape.kind != "box":
                halves[0] = shape.sizes[0]
            words = {"type": shape.kind, "size": numbers(halves), "group": GROUPS["collision"]}
            element(
                bodies[link.name], "geom", None, **words, **placement(shape.pose), **NO_COLLISIONS
            )
