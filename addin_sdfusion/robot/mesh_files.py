"""Files of meshes by their URIs, and which of them may be opened and packed.

A robot may come from a stranger and name any file of this machine as a mesh. So what is packed,
drawn or collided with lies in the folder of the robot or of the experiment, or was named by the
user, links followed; `lies_in` decides it for every kind of file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from .errors import InputError
from .files import read_file
from .limits import MESH
from .mesh_content import mesh_problem

MODEL_URIS = ("model://", "package://")
_FILE_URI = "file://"
_NETWORK = ("//", "\\\\")  # looking there shows another machine who asks


def mesh_file(uri: str, folder: Path | None, roots: Iterable[Path] | None = None) -> Path:
    """Return the file that a mesh's URI means.

    A model of a name is looked for next to the robot's folder, as Gazebo does, and, as a robot's
    folder may have been renamed, in the folder itself; so is whatever has travelled with the robot.

    Args:
        uri: `model://name/path`, `package://name/path`, `file://path` or a path; a name in it may
            be percent-encoded.
        folder: Folder of the robot's file; the working directory when None.
        roots: As for `lies_in`; files elsewhere are taken if there is no other.

    Returns:
        The file that is there, or else the first that was looked for.
    """
    folder = Path() if folder is None else folder
    files = list(_places(uri, folder)) or [folder / packed_name(uri)]
    there = [file for file in files if is_file(file)]
    if roots is not None:
        there.sort(key=lambda file: not lies_in(file, roots))
    return next(iter(there), files[0])


def allowed_mesh_file(uri: str, folder: Path | None, roots: Iterable[Path] | None) -> Path:
    """As `mesh_file`, of files that may be opened alone.

    Args:
        uri: As `mesh_file` takes it.
        folder: Folder of the robot's file; the working directory when None.
        roots: As for `lies_in`; None admits every file.

    Raises:
        InputError: The file lies elsewhere.
    """
    file = mesh_file(uri, folder, roots)
    if roots is not None and is_file(file) and not lies_in(file, roots):
        raise InputError(f"mesh {uri!r} {OUTSIDE}", file=file)
    return file


OUTSIDE = (
    "lies outside the folders of robot and experiment, where links are followed, and is neither "
    "opened nor packed; copy it into one of them"
)


def lies_in(file: Path, roots: Iterable[Path]) -> bool:
    """Return whether a file is in certain folders, where links are followed.

    Args:
        file: The file.
        roots: Folders, or single files.
    """
    try:
        place = file.resolve(strict=True)
        return any(place.is_relative_to(root.resolve()) for root in roots)
    except (OSError, ValueError, RuntimeError):
        return False


def mesh_bytes(file: Path, roots: Iterable[Path] | None) -> bytes:
    """Return the content of a mesh, to be read or packed.

    Args:
        file: The file.
        roots: As for `lies_in`; None admits every file.

    Raises:
        InputError: It lies elsewhere, cannot be read, or is not a mesh.
    """
    if roots is not None and is_file(file) and not lies_in(file, roots):
        raise InputError(OUTSIDE, file=file)
    data = read_file(file, MESH)
    problem = mesh_problem(file.suffix, data)
    if problem is not None:
        raise InputError(f"cannot be used as a mesh: {problem}", file=file)
    return data


def packed_name(uri: str) -> str:
    """Path of a mesh below its robot's folder when it travels with it.

    Args:
        uri: As `mesh_file` takes it.
    """
    path = uri.removeprefix(_FILE_URI)
    if uri.startswith(MODEL_URIS):
        path = uri.partition("://")[2].partition("/")[2]
    parts = [part for part in PurePosixPath(unquote(path)).parts if part not in ("/", "//", "..")]
    return "/".join(part.replace("\\", "_").replace(":", "_") for part in parts)


def is_file(path: Path) -> bool:
    """Return whether there is a file; a path that no file can have holds none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _places(uri: str, folder: Path) -> Iterator[Path]:
    """Where to look, the names first as they are and then decoded."""
    for words in (uri, unquote(uri)):
        path = words.removeprefix(_FILE_URI)
        if path.startswith(_NETWORK):
            continue
        if not words.startswith(MODEL_URIS):
            yield folder / path
            continue
        name, _, path = words.partition("://")[2].partition("/")
        yield folder.resolve().parent / name / path.lstrip("/")
        yield folder / path.lstrip("/")
    yield folder / packed_name(uri)
