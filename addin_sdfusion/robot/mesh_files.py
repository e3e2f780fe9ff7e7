"""Files of meshes by their URIs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

MODEL_URI = "model://"
_FILE_URI = "file://"


def mesh_file(uri: str, folder: Path | None) -> Path:
    """The file that a mesh's URI means.

    A model of a name is looked for beside the robot's folder, as Gazebo does, and, as a robot's
    folder may have been renamed, in the folder itself; so is whatever has travelled with the robot.

    Args:
        uri: `model://name/path`, `file://path` or a path; a name in it may be percent-encoded.
        folder: Folder of the robot's file; the working directory when None.

    Returns:
        The file that is there, or else the first that was looked for.
    """
    files = list(_places(uri, Path() if folder is None else folder))
    return next((file for file in files if is_file(file)), files[0])


def own_name(uri: str) -> str:
    """Path of a mesh below its robot's folder when it travels with it.

    Args:
        uri: As `mesh_file` takes it.
    """
    path = uri.removeprefix(_FILE_URI)
    if uri.startswith(MODEL_URI):
        path = uri.removeprefix(MODEL_URI).partition("/")[2]
    parts = [part for part in PurePosixPath(unquote(path)).parts if part not in ("/", "..")]
    return "/".join(part.replace("\\", "_").replace(":", "_") for part in parts)


def is_file(path: Path) -> bool:
    """Whether there is a file; a path that no file can have holds none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _places(uri: str, folder: Path) -> Iterator[Path]:
    """Where to look, the names first as they are and then decoded."""
    for words in (uri, unquote(uri)):
        if not words.startswith(MODEL_URI):
            yield folder / words.removeprefix(_FILE_URI)
            continue
        name, _, path = words.removeprefix(MODEL_URI).partition("/")
        yield folder.resolve().parent / name / path
        yield folder / path
    yield folder / own_name(uri)
