"""Files that are packed with an experiment into FMUs, .ssp files and results.

Experiments and robots may be untrusted. Therefore only files in their folders and files that the
user has named explicitly are packed, and mesh files must contain meshes.
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
    allowed_mesh_file,
    is_file,
    lies_in,
    mesh_bytes,
    mesh_file,
    packed_name,
)
from addin_sdfusion.robot.model.robot import Mesh

from .config.custom_law import CustomLaw

Files = dict[str, bytes | Path]
"""Content, or a file to copy, by path in the archive."""


def named_files(settings: Any, folder: Path) -> tuple[Path, ...]:
    """Return the existing files that settings name, at any depth."""
    if isinstance(settings, str):
        law = CustomLaw.of(settings)
        file = folder / (settings if law is None else law.file)
        return (file,) if is_file(file) else ()
    parts = settings.values() if isinstance(settings, Mapping) else settings
    if not isinstance(parts, Iterable):
        return ()
    return tuple(file for part in parts for file in named_files(part, folder))


def mesh_roots(file: Path, robots: Iterable[Path], named: Iterable[Path]) -> tuple[Path, ...]:
    """Return the folders and files that may be packed; see `lies_in`.

    Args:
        robots: Main files of its robots.
        named: Files that the user has named explicitly.
    """
    return (file.parent, *(robot.parent for robot in robots), *named)


def require_packable(file: Path, roots: Sequence[Path], key: str | None = None) -> Path:
    """Check that a file may be packed.

    Raises:
        InputError: The file is outside of the allowed folders.
    """
    if is_file(file) and not lies_in(file, roots):
        raise InputError(OUTSIDE, file=file, key=key)
    return file


def require_archive_paths(data: Mapping[str, Any], file: Path) -> None:
    """Check that all paths of an experiment in an archive refer to files in the archive.

    Raises:
        InputError: A path is absolute, contains `..`, or leads to a file outside of the archive.
    """
    for key, path in _paths(data):
        if not isinstance(path, str):
            continue
        parts = PurePosixPath(path.replace("\\", "/"))
        if parts.is_absolute() or ".." in parts.parts or ":" in path:
            problem = f"{path!r} is outside of the archive of the experiment"
            raise InputError(problem, file=file, key=key)
        if (file.parent / path).exists() and not lies_in(file.parent / path, [file.parent]):
            problem = f"{path!r} is a link to a file outside of the archive of the experiment"
            raise InputError(problem, file=file, key=key)


def require_archive_files(files: Iterable[Path], folder: Path) -> None:
    """Check that all files of a robot are in the unpacked archive.

    Raises:
        InputError: A file is outside of the folder.
    """
    for file in files:
        if not lies_in(file, [folder]):
            problem = "is used by a robot in an archive, but is outside of the archive"
            raise InputError(problem, file=file)


def _paths(data: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield key and value of each path in an experiment."""
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
    yield "controller.gains", _table(data, "controller").get("gains")
    law = _table(data, "controller").get("type")
    yield "controller.type", law.rpartition(":")[0] if isinstance(law, str) else None
    yield "controller.policy", _table(data, "controller").get("policy")
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


def robot_folder(place: str, files: Sequence[Path]) -> str:
    """Return the folder of the main file of a robot in an archive.

    Relative paths between the files of a robot stay valid: the folder keeps its depth below the
    common folder of all files.

    Args:
        place: Path of the robot in the archive.
        files: The files, the main file first.
    """
    return PurePosixPath(
        place, *_normalized(files[0]).parent.relative_to(_common_folder(files)).parts
    ).as_posix()


def robot_files(place: str, files: Sequence[Path], roots: Sequence[Path]) -> Files:
    """Return all files of a robot, by path in the archive.

    Raises:
        InputError: A file or the target of a link is outside of the allowed folders.
    """
    common = _common_folder([require_packable(file, roots) for file in files])
    return {f"{place}/{_normalized(file).relative_to(common).as_posix()}": file for file in files}


def _common_folder(files: Sequence[Path]) -> Path:
    return Path(os.path.commonpath([_normalized(file).parent for file in files]))


def _normalized(file: Path) -> Path:
    """Return an absolute path without `..`."""
    return Path(os.path.normpath(file.absolute()))


def collision_meshes(place: str, robot: Robot, folder: Path, roots: Sequence[Path]) -> Files:
    """Return the collision meshes of a robot, by path in the archive.

    Args:
        place: Path of the robot's folder in the archive.
        roots: As for `lies_in`.

    Raises:
        InputError: A mesh may not be packed.
    """
    files: dict[str, Path] = {}
    for _, mesh in _meshes(robot, "collision"):
        file = allowed_mesh_file(mesh.uri, folder, roots)
        if files.setdefault(packed_name(mesh.uri), file) != file:
            problem = f"has the name {packed_name(mesh.uri)!r} of another mesh; rename it"
            raise InputError(problem, file=file)
    return {f"{place}/{name}": mesh_bytes(file, roots) for name, file in files.items()}


def visual_meshes(place: str, robot: Robot, folder: Path, roots: Sequence[Path]) -> Files:
    """Return the existing visual meshes of a robot that may be packed."""
    packed: dict[str, Path] = {}
    for _, mesh in _meshes(robot, "visual"):
        file = mesh_file(mesh.uri, folder, roots)
        if is_file(file) and packing_problem(file, roots) is None:
            packed.setdefault(packed_name(mesh.uri), file)
    return {f"{place}/{name}": mesh_bytes(file, roots) for name, file in packed.items()}


def omitted_meshes(robot: Robot, folder: Path, roots: Sequence[Path]) -> list[str]:
    """Describe the existing visual meshes that may not be packed, one line each with the reason."""
    lines: dict[str, None] = {}
    names: dict[str, Path] = {}
    for link, mesh in _meshes(robot, "visual"):
        file = mesh_file(mesh.uri, folder, roots)
        if not is_file(file):
            continue
        reason = packing_problem(file, roots)
        if reason is None and names.setdefault(packed_name(mesh.uri), file) != file:
            reason = f"has the name {packed_name(mesh.uri)!r} of another mesh; rename it"
        if reason is not None:
            lines[f"mesh {mesh.uri!r} of link {link!r} is not packed: it {reason}"] = None
    return list(lines)


def packing_problem(file: Path, roots: Sequence[Path]) -> str | None:
    """Return the reason why an existing mesh may not be packed; None if it may be packed."""
    if not lies_in(file, roots):
        return OUTSIDE
    state = file.stat()
    return _content_problem(file, state.st_mtime_ns, state.st_size)


@functools.lru_cache(maxsize=1024)
def _content_problem(file: Path, changed: int, size: int) -> str | None:
    """Return the reason why a file is not a valid mesh, or None."""
    try:
        mesh_bytes(file, [file])
    except InputError as error:
        return error.problem
    return None


def world_meshes(world: Mapping[str, Any], roots: Sequence[Path]) -> tuple[dict[str, Any], Files]:
    """Return the table [world] with paths of packed meshes, and these meshes."""
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
    """Yield the meshes of a role with the names of their links."""
    for link in robot.links:
        for mesh in link.meshes:
            if mesh.role == role:
                yield link.name, mesh
