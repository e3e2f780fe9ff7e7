"""Files of a robot's visual meshes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from addin_sdfusion.robot import Link, Mesh, Robot
from addin_sdfusion.robot.mesh_files import is_file, lies_in, mesh_file


def visual_files(
    robot: Robot, folder: Path, roots: Sequence[Path] | None = None
) -> dict[str, Path]:
    """Return the existing and allowed files of the visual meshes, by their URIs."""
    roots = (folder,) if roots is None else roots
    uris = sorted({mesh.uri for link in robot.links for mesh in visuals(link)})
    files = {uri: mesh_file(uri, folder, roots) for uri in uris}
    return {uri: file for uri, file in files.items() if is_file(file) and lies_in(file, roots)}


def visuals(link: Link) -> list[Mesh]:
    """Return the visual meshes of a link."""
    return [mesh for mesh in link.meshes if mesh.role == "visual"]
