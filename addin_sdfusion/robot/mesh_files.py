"""Where the file of a mesh is, as its URI says it."""

from __future__ import annotations

from pathlib import Path

MODEL_URI = "model://"


def mesh_file(uri: str, folder: Path | None) -> Path:
    """The file that a mesh's URI means.

    A model of a name is looked for beside the robot's folder, as Gazebo does, and, as a robot's
    folder may have been renamed, in the folder itself.

    Args:
        uri: `model://name/path`, `file://path` or a path.
        folder: Where the robot's file stands; the working directory when None.

    Returns:
        The file that is there, or else the first that was looked for.
    """
    place = Path() if folder is None else folder
    if not uri.startswith(MODEL_URI):
        return place / uri.removeprefix("file://")
    name, _, path = uri.removeprefix(MODEL_URI).partition("/")
    files = [place.resolve().parent / name / path, place / path]
    return next((file for file in files if is_file(file)), files[0])


def is_file(path: Path) -> bool:
    """Whether there is a file; a path that no file can have holds none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False
