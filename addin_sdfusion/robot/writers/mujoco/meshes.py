"""Meshes in MJCF: assets, and geoms without collisions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree

from ...finding import Finding, Subject
from ...finding_builders import warning
from ...model.robot import Robot
from ...transforms.joint_chains import Names
from ..xml_text import element, numbers
from .bodies import placement

GROUPS = {"visual": "2", "collision": "4"}


def add_meshes(
    robot: Robot,
    files: Mapping[str, str | Path],
    assets: ElementTree.Element,
    bodies: dict[str, ElementTree.Element],
) -> None:
    """Add the meshes whose files are known."""
    names = Names()
    for link in robot.links:
        for mesh in link.meshes:
            if mesh.uri not in files:
                continue
            name = names.give(mesh.name or f"{link.name} {mesh.role}")
            file, scale = str(files[mesh.uri]), numbers(mesh.scale)
            element(assets, "mesh", name=name, file=file, scale=scale)
            shape = {"type": "mesh", "mesh": name, "group": GROUPS[mesh.role]}
            apart = {"contype": "0", "conaffinity": "0"}
            element(bodies[link.name], "geom", None, **shape, **placement(mesh.pose), **apart)


def mesh_losses(robot: Robot, files: Mapping[str, str | Path]) -> Iterator[Finding]:
    """Meshes that are left out, and collisions that are off."""
    for link in robot.links:
        subject = Subject("link", link.name)
        for mesh in link.meshes:
            if mesh.uri not in files:
                problem = f"MuJoCo opens every mesh; no file is known for {mesh.uri!r}: left out"
                yield warning(subject, "mesh-left-out", problem)
            elif mesh.role == "collision":
                problem = f"the collisions of mesh {mesh.uri!r} are off, as in this simulation"
                yield warning(subject, "collisions-off", problem)
