"""The files that travel with an experiment, in FMUs, .ssp files and results, and those that do not.

An experiment or its robot may come from a stranger. What travels therefore lies in the folders of
experiment and robots, or was named by whoever loads the experiment, and meshes are meshes.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.mesh_files import (
    OUTSIDE,
    is_file,
    lies_in,
    mesh_bytes,
    mesh_file,
    own_mesh,
    own_name,
)
from addin_sdfusion.robot.model.robot import Mesh

from .settings.custom_law import CustomLaw

Files = dict[str, bytes | Path]
"""Content, or a file to copy, by its path below the archive's root."""


def named_files(settings: Any, folder: Path) -> tuple[Path, ...]:
    """Files that settings name, wherever in them.

    Args:
        settings: Plain data.
        folder: Where relative paths begin.
    """
    if isinstance(settings, str):
        law = CustomLaw.of(settings)
        file = folder / (settings if law is None else law.file)
        return (file,) if is_file(file) else ()
    parts = settings.values() if isinstance(settings, Mapping) else settings
    if not isinstance(parts, Iterable):
        return ()
    return tuple(file for part in parts for file in named_files(part, folder))


def mesh_roots(file: Path, robots: Iterable[Path], named: Iterable[Path]) -> tuple[Path, ...]:
    """Where files may travel from: see `lies_in`.

    Args:
        file: The experiment's file.
        robots: The main files of its robots.
        named: Files that its user has named.
    """
    return (file.parent, *(robot.parent for robot in robots), *named)


def require_own(file: Path, roots: Sequence[Path], key: str | None = None) -> Path:
    """Refuse a file that may not travel.

    Args:
        file: The file.
        roots: As for `lies_in`.
        key: The setting that names it.

    Raises:
        InputError: It lies elsewhere.
    """
    if is_file(file) and not lies_in(file, roots):
        raise InputError(OUTSIDE, file=file, key=key)
    return file


def require_closed(data: Mapping[str, Any], file: Path) -> None:
    """Refuse an experiment among the files of an archive that leads out of the archive.

    Args:
        data: The content of the experiment's file.
        file: The file, for messages.

    Raises:
        InputError: A path in it is absolute or leads up, or it names external FMUs or a key.
    """
    for key, path in _paths(data):
        if not isinstance(path, str):
            continue
        parts = PurePosixPath(path.replace("\\", "/"))
        if parts.is_absolute() or ".." in parts.parts or ":" in path:
            what = f"{path!r} leads out of the archive that the experiment came in"
            raise InputError(what, file=file, key=key)
        if (file.parent / path).exists() and not lies_in(file.parent / path, [file.parent]):
            what = f"{path!r} is a link that leads out of the archive that the experiment came in"
            raise InputError(what, file=file, key=key)


def require_carried(own: Iterable[Path], folder: Path) -> None:
    """Refuse a robot in an archive that names files outside of it.

    Args:
        own: The files of the robot.
        folder: Where the archive is unpacked.

    Raises:
        InputError: One lies elsewhere.
    """
    for file in own:
        if not lies_in(file, [folder]):
            what = "is named by a robot in an archive, and lies outside of the archive"
            raise InputError(what, file=file)


def _paths(data: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """The paths in an experiment, by their keys."""
    yield "robot.path", _table(data, "robot").get("path")
    for key, rows, entry in (
        ("robots", data.get("robots"), "path"),
        ("world.objects", _table(data, "world").get("objects"), "file"),
        ("world.shapes", _table(data, "world").get("shapes"), "file"),
    ):
        for k, row in enumerate(rows if isinstance(rows, list) else ()):
            yield f"{key}[{k}].{entry}", row.get(entry) if isinstance(row, dict) else None
    yield "world.sdf", _table(data, "world").get("sdf")
    yield "reference.file", _table(data, "reference").get("file")
    law = _table(data, "controller").get("type")
    yield "controller.type", law.rpartition(":")[0] if isinstance(law, str) else None
    for name, muscle in _table(data, "muscles").items():
        model = muscle.get("model") if isinstance(muscle, dict) else None
        law = model.get("kind") if isinstance(model, dict) else model
        yield f"muscles.{name}.model", law.rpartition(":")[0] if isinstance(law, str) else None
    yield "hardware.key_file", _table(data, "hardware").get("key_file")
    for role, fmu in _table(data, "fmus").items():
        yield f"fmus.{role}", fmu.get("path") if isinstance(fmu, dict) else fmu


def _table(data: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    table = data.get(key)
    return table if isinstance(table, Mapping) else {}


def robot_folder(place: str, own: Sequence[Path]) -> str:
    """Where the folder of a robot's main file is in an archive.

    It is as deep as there is above it what other files of the robot are in: a model that it
    includes from beside its folder stays beside it.

    Args:
        place: Path of the robot in the archive.
        own: The files, the main one first.
    """
    return PurePosixPath(place, *_plain(own[0]).parent.relative_to(_common(own)).parts).as_posix()


def robot_files(place: str, own: Sequence[Path], roots: Sequence[Path]) -> Files:
    """The files that make up a robot.

    Args:
        place: Path of the robot in the archive.
        own: The files, the main one first.
        roots: As for `lies_in`.

    Raises:
        InputError: One of them lies elsewhere, or is a link to a file elsewhere.
    """
    common = _common([require_own(file, roots) for file in own])
    return {f"{place}/{_plain(file).relative_to(common).as_posix()}": file for file in own}


def _common(own: Sequence[Path]) -> Path:
    """The folder that all files of a robot lie in."""
    return Path(os.path.commonpath([_plain(file).parent for file in own]))


def _plain(file: Path) -> Path:
    """A path without `..`."""
    return Path(os.path.normpath(file.absolute()))


def collision_meshes(place: str, robot: Robot, folder: Path, roots: Sequence[Path]) -> Files:
    """The collision meshes of a robot, without which it cannot be simulated.

    Args:
        place: Path of the robot's folder in the archive.
        robot: The robot.
        folder: Its folder.
        roots: As for `lies_in`.

    Raises:
        InputError: One of them may not travel.
    """
    files: dict[str, Path] = {}
    for _, mesh in _meshes(robot, "collision"):
        file = own_mesh(mesh.uri, folder, roots)
        if files.setdefault(own_name(mesh.uri), file) != file:
            what = f"would travel as {own_name(mesh.uri)!r}, as another mesh does; rename it"
            raise InputError(what, file=file)
    return {f"{place}/{name}": mesh_bytes(file, roots) for name, file in files.items()}


def visual_meshes(place: str, robot: Robot, folder: Path, roots: Sequence[Path]) -> Files:
    """The visual meshes of a robot that are there and may travel.

    Args:
        place: Path of the robot's folder in the archive.
        robot: The robot.
        folder: Its folder.
        roots: As for `lies_in`.
    """
    taken: dict[str, Path] = {}
    for _, mesh in _meshes(robot, "visual"):
        file = mesh_file(mesh.uri, folder, roots)
        if is_file(file) and refusal(file, roots) is None:
            taken.setdefault(own_name(mesh.uri), file)
    return {f"{place}/{name}": mesh_bytes(file, roots) for name, file in taken.items()}


def left_out(robot: Robot, folder: Path, roots: Sequence[Path]) -> list[str]:
    """The visual meshes that are there and do not travel, a line each with the reason.

    Args:
        robot: The robot.
        folder: Its folder.
        roots: As for `lies_in`.
    """
    lines: dict[str, None] = {}
    names: dict[str, Path] = {}
    for link, mesh in _meshes(robot, "visual"):
        file = mesh_file(mesh.uri, folder, roots)
        if not is_file(file):
            continue
        reason = refusal(file, roots)
        if reason is None and names.setdefault(own_name(mesh.uri), file) != file:
            reason = f"would travel as {own_name(mesh.uri)!r}, as another mesh does; rename it"
        if reason is not None:
            lines[f"mesh {mesh.uri!r} of link {link!r} is left out: it {reason}"] = None
    return list(lines)


def refusal(file: Path, roots: Sequence[Path]) -> str | None:
    """Why a mesh that is there may not travel; None where it may."""
    if not lies_in(file, roots):
        return OUTSIDE
    state = file.stat()
    return _content_problem(file, state.st_mtime_ns, state.st_size)


@functools.lru_cache(maxsize=1024)
def _content_problem(file: Path, changed: int, size: int) -> str | None:
    """What keeps the content of a file from being a mesh's, asked once while it is unchanged."""
    try:
        mesh_bytes(file, [file])
    except InputError as error:
        return error.what
    return None


def world_meshes(world: Mapping[str, Any], roots: Sequence[Path]) -> tuple[dict[str, Any], Files]:
    """The table [world] with the meshes of objects and links beside it, and these.

    Raises:
        InputError: One of them may not travel.
    """
    files: Files = {}
    rows: dict[str, list[dict[str, Any]]] = {}
    for key in ("objects", "shapes"):
        rows[key] = []
        for k, row in enumerate(world[key]):
            if "file" not in row:
                rows[key].append(row)
                continue
            source = Path(row["file"])
            target = f"world/{key}_{k}{source.suffix}"
            files[target] = mesh_bytes(source, roots)
            rows[key].append({**row, "file": target})
    return {**world, **rows}, files


def _meshes(robot: Robot, role: str) -> Iterator[tuple[str, Mesh]]:
    """The meshes of a role, each with the name of its link."""
    for link in robot.links:
        for mesh in link.meshes:
            if mesh.role == role:
                yield link.name, mesh
