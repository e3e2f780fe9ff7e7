"""Check that the mesh files of a robot exist."""

from __future__ import annotations

from collections.abc import Iterable

from ...mesh_files import is_file, lies_in, mesh_file
from ...model.robot import Link
from .xml import Node, short_repr


def note_missing_meshes(model: Node, links: Iterable[Link]) -> None:
    """Report missing mesh files and mesh files outside the robot folder, one warning each."""
    uris = list(dict.fromkeys(mesh.uri for link in links for mesh in link.meshes))
    folder = model.file.parent
    files = {uri: mesh_file(uri, folder, [folder]) for uri in uris}
    missing = [uri for uri, file in files.items() if not is_file(file)]
    outside = [uri for uri, file in files.items() if is_file(file) and not lies_in(file, [folder])]
    if outside:
        problem = (
            f"{len(outside)} of {len(uris)} mesh files are outside the robot's folder, such as "
            f"{short_repr(outside[0])}; they are shown and packed only if they are in the folder "
            "of the experiment"
        )
        model.warning("meshes-outside", problem)
    if missing:
        problem = (
            f"{len(missing)} of {len(uris)} mesh files are not found, such as "
            f"{short_repr(missing[0])}; the robot is simulated without them"
        )
        model.warning("missing-meshes", problem)
