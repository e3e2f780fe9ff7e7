"""Formats of robots' files, recognised by name and content."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal

from ..errors import InputError
from ..files import is_folder, read_file
from ..limits import XML
from .caspr.read import BODIES

Kind = Literal["sdf", "caspr", "urdf", "mjcf", "osim"]

WHAT = f"a model.sdf, .urdf, .osim, MJCF .xml or *{BODIES}, or the folder of one"
"""What can be given as a robot."""
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
    """Return the format of a file; None if it is not a robot's.

    Raises:
        InputError: It cannot be read.
    """
    if file.name.endswith(BODIES):
        return "caspr"
    if file.suffix in BY_SUFFIX:
        return BY_SUFFIX[file.suffix]
    return BY_ROOT.get(_root(read_file(file, XML).replace(b"\0", b"")))


def _root(text: bytes) -> str:
    """The name of XML's first element, behind comments and declarations; empty if none is there."""
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
    """Return the file to begin with: the path itself, or the one robot in a folder.

    Raises:
        InputError: A folder holds none, or several.
    """
    try:
        if not path.is_dir():
            return path
        names = sorted(entry.name for entry in path.iterdir())
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=path) from error
    found = _robots_among(path, names)
    if len(found) == 1:
        return path / found[0]
    there = ", ".join(names[:20]) + (", ..." if len(names) > 20 else "")
    robots = f"{len(found)} robots ({', '.join(found[:10])})" if found else "no robot"
    what = f"holds {robots} and no model.sdf (there: {there or 'nothing'})"
    raise InputError(f"{what}; name the robot's file: {WHAT}", file=path)


def holds_robot(path: Path) -> bool:
    """Return whether a path is a robot's file, or a folder that holds one."""
    try:
        return kind_of(robot_file(path)) is not None
    except (InputError, OSError, ValueError):
        return False


def _robots_among(folder: Path, names: list[str]) -> list[str]:
    """Return the robots' files of a folder, of the formats in their order."""
    if "model.sdf" in names:
        return ["model.sdf"]
    for suffix in (BODIES, ".urdf", ".osim"):
        found = [name for name in names if name.endswith(suffix)]
        if found:
            return found
    return [name for name in names if name.endswith(".xml") and _is_robot(folder / name)]


def _is_robot(file: Path) -> bool:
    try:
        return not is_folder(file) and kind_of(file) is not None
    except InputError:
        return False
