"""Where the files of a robot's visual meshes are."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from addin_sdfusion.robot import Link, Mesh, Robot

_MODEL, _FILE = "model://", "file://"


def mesh_files(robot: Robot, folder: Path) -> dict[str, Path]:
    """The files of the visual meshes that are there, by their URIs.

    Args:
        robot: The robot.
        folder: Where its main file stands.
    """
    uris = {mesh.uri for link in robot.links for mesh in visuals(link)}
    found = {uri: _file(uri, folder) for uri in sorted(uris)}
    return {uri: file for uri, file in found.items() if file is not None}


def visuals(link: Link) -> list[Mesh]:
    """The meshes that a link looks like."""
    return [mesh for mesh in link.meshes if mesh.role == "visual"]


def own_name(uri: str) -> str:
    """Where a mesh stands below its robot's folder when it travels with it."""
    path = uri.removeprefix(_FILE)
    if uri.startswith(_MODEL):
        path = uri.removeprefix(_MODEL).partition("/")[2]
    parts = [part for part in PurePosixPath(unquote(path)).parts if part not in ("/", "..")]
    return "/".join(part.replace("\\", "_").replace(":", "_") for part in parts)


def _file(uri: str, folder: Path) -> Path | None:
    for place in _places(uri, folder):
        with contextlib.suppress(OSError, ValueError):
            if place.is_file():
                return place
    return None


def _places(uri: str, folder: Path) -> Iterator[Path]:
    """Where SDF looks, and then below the robot's own folder."""
    if uri.startswith(_MODEL):
        yield folder.resolve().parent / unquote(uri.removeprefix(_MODEL))
    else:
        yield folder / unquote(uri.removeprefix(_FILE))
    yield folder / own_name(uri)
