"""Files of a robot's visual meshes."""

from __future__ import annotations

from pathlib import Path

from addin_sdfusion.robot import Link, Mesh, Robot
from addin_sdfusion.robot.mesh_files import is_file, mesh_file


def visual_files(robot: Robot, folder: Path) -> dict[str, Path]:
    """The files of the visual meshes that are there, by their URIs."""
    uris = sorted({mesh.uri for link in robot.links for mesh in visuals(link)})
    files = {uri: mesh_file(uri, folder) for uri in uris}
    return {uri: file for uri, file in files.items() if is_file(file)}


def visuals(link: Link) -> list[Mesh]:
    """The meshes that a link looks like."""
    return [mesh for mesh in link.meshes if mesh.role == "visual"]
