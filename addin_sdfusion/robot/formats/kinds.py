"""Detection of the format of robot files from their names and contents."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal

from ..errors import InputError
from ..files import is_folder, read_file
from ..limits import XML
from .caspr.read import BODIES

Kind = Literal["sdf", "caspr", "urdf", "mjcf", "osim"]

ROBOT_PATHS = f"a model.sdf, .urdf, .osim, MJCF .xml or *{BODIES}, or the folder of one"
"""Description of the paths that are accepted as a robot."""
BY_SUFFIX: dict[str, Kind] = {".sdf": "sdf", ".urdf": "urdf", ".xacro": "urdf", ".osim": "osim"}
BY_ROOT: dict[str, Kind] = {
    "mujoco": "mjcf",
    "robot": "urdf",
    "OpenSimDocument": "osim",
    "sdf": "sdf",
}
_TAG = re.compile(rb"<(?:([A-Za-z_][\w.:-]*)|\?|!--|!)")
_ENDS = {b"<?": b"?>", b"<!--": b"-->"}


def kind_of(file: Path) -> Kind | None:
    """Return the format of a file, or None if it is not a robot file."""
    if file.name.endswith(BODIES):
        return "caspr"
    if file.suffix in BY_SUFFIX:
        return BY_SUFFIX[file.suffix]
    return BY_ROOT.get(_root(read_file(file, XML).replace(b"\0", b"")))


def _root(text: bytes) -> str:
    """Return the tag of the first XML element, or an empty string if no element is found."""
    at = 0
    while (tag := _TAG.search(text, at)) is not None:
        if tag[1] is not None:
            return tag[1].decode("ascii", "replace")
        end = text.find(_ENDS.get(tag[0], b">"), tag.end())
        inner = text.find(b"[", tag.end(), max(end, 0)) if tag[0] == b"<!" else -1
        if inner >= 0:
            inner = text.find(b"]", inner)
            end = text.find(b">", inner) if inner >= 0 else -1
        if end < 0:
            break
        at = end + 1
    return ""


def robot_file(path: Path) -> Path:
    """Return the main file of a robot: the path, or the only robot file in a folder.

    Raises:
        InputError: The folder contains no robot file or several.
    """
    try:
        if not path.is_dir():
            return path
        names = sorted(entry.name for entry in path.iterdir())
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=path) from error
    files = _robot_files(path, names)
    if len(files) == 1:
        return path / files[0]
    listing = ", ".join(names[:20]) + (", ..." if len(names) > 20 else "")
    robots = f"{len(files)} robots ({', '.join(files[:10])})" if files else "no robot"
    problem = f"contains {robots} and no model.sdf (files: {listing or 'none'})"
    raise InputError(f"{problem}; specify the robot file: {ROBOT_PATHS}", file=path)


def holds_robot(path: Path) -> bool:
    """Return whether a path is a robot file or a folder that contains exactly one."""
    try:
        return kind_of(robot_file(path)) is not None
    except (InputError, OSError, ValueError):
        return False


def _robot_files(folder: Path, names: list[str]) -> list[str]:
    """Return the robot files in a folder, of the first format that is found."""
    if "model.sdf" in names:
        return ["model.sdf"]
    for suffix in (BODIES, ".urdf", ".osim"):
        matching = [name for name in names if name.endswith(suffix)]
        if matching:
            return matching
    return [name for name in names if name.endswith(".xml") and _is_robot(folder / name)]


def _is_robot(file: Path) -> bool:
    try:
        return not is_folder(file) and kind_of(file) is not None
    except InputError:
        return False
