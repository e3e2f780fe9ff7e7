"""Mesh files by their URIs, and the check of files that may be opened and packed.

An untrusted robot can name any file of this computer as a mesh. Therefore a mesh is only used if,
after links are resolved, it is in the folder of the robot or of the experiment, or if the user
named it. `lies_in` checks this for every kind of file.
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
_NETWORK = ("//", "\\\\")  # access would reveal the user to another computer


def mesh_file(uri: str, folder: Path | None, roots: Iterable[Path] | None = None) -> Path:
    """Return the file that a mesh URI refers to.

    A model is searched next to the robot's folder, as in Gazebo, and in the folder itself, since
    the folder may have been renamed. Meshes that were packed with the robot are also in its folder.

    Args:
        uri: `model://name/path`, `package://name/path`, `file://path` or a path; its parts may be
            percent-encoded.
        folder: Folder of the robot's file, or None for the working directory.
        roots: Preferred folders, see `lies_in`. Other files are used if these have no match.

    Returns:
        The first existing file, or the first candidate if no file exists.
    """
    folder = Path() if folder is None else folder
    files = list(_candidates(uri, folder)) or [folder / packed_name(uri)]
    existing = [file for file in files if is_file(file)]
    if roots is not None:
        existing.sort(key=lambda file: not lies_in(file, roots))
    return next(iter(existing), files[0])


def allowed_mesh_file(uri: str, folder: Path | None, roots: Iterable[Path] | None) -> Path:
    """Return the file of a mesh URI, as `mesh_file`, and reject files outside of the roots.

    Args:
        uri: See `mesh_file`.
        folder: Folder of the robot's file, or None for the working directory.
        roots: Allowed folders, see `lies_in`; None allows every file.

    Raises:
        InputError: The file is outside of the roots.
    """
    file = mesh_file(uri, folder, roots)
    if roots is not None and is_file(file) and not lies_in(file, roots):
        raise InputError(f"mesh {uri!r} {OUTSIDE}", file=file)
    return file


OUTSIDE = (
    "is outside the folders of robot and experiment after links are resolved, and is neither "
    "opened nor packed; copy it into one of these folders"
)


def lies_in(file: Path, roots: Iterable[Path]) -> bool:
    """Return whether a file is in one of several folders, after links are resolved.

    Args:
        roots: Folders, or single files.
    """
    try:
        resolved = file.resolve(strict=True)
        return any(resolved.is_relative_to(root.resolve()) for root in roots)
    except (OSError, ValueError, RuntimeError):
        return False


def mesh_bytes(file: Path, roots: Iterable[Path] | None) -> bytes:
    """Return the content of a mesh file.

    Args:
        roots: Allowed folders, see `lies_in`; None allows every file.

    Raises:
        InputError: The file is outside of the roots, cannot be read, or is not a mesh.
    """
    if roots is not None and is_file(file) and not lies_in(file, roots):
        raise InputError(OUTSIDE, file=file)
    data = read_file(file, MESH)
    problem = mesh_problem(file.suffix, data)
    if problem is not None:
        raise InputError(f"cannot be used as a mesh: {problem}", file=file)
    return data


def packed_name(uri: str) -> str:
    """Return the path of a mesh relative to the robot's folder when it is packed with the robot.

    Args:
        uri: See `mesh_file`.
    """
    path = uri.removeprefix(_FILE_URI)
    if uri.startswith(MODEL_URIS):
        path = uri.partition("://")[2].partition("/")[2]
    parts = [part for part in PurePosixPath(unquote(path)).parts if part not in ("/", "//", "..")]
    return "/".join(part.replace("\\", "_").replace(":", "_") for part in parts)


def is_file(path: Path) -> bool:
    """Return whether a path is an existing file; False for an invalid path."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _candidates(uri: str, folder: Path) -> Iterator[Path]:
    """Yield the files that a URI may refer to, first without and then with percent-decoding."""
    for text in (uri, unquote(uri)):
        path = text.removeprefix(_FILE_URI)
        if path.startswith(_NETWORK):
            continue
        if not text.startswith(MODEL_URIS):
            yield folder / path
            continue
        name, _, path = text.partition("://")[2].partition("/")
        yield folder.resolve().parent / name / path.lstrip("/")
        yield folder / path.lstrip("/")
    yield folder / packed_name(uri)
