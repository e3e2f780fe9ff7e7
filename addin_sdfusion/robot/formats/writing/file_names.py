"""Files of single documents, and their names."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from ...checks.check import require_valid
from ...errors import InputError
from ...files import write_files
from ...finding import Finding, Subject
from ...finding_builders import error
from ...model.robot import Robot

_MAX_BYTES = 200
"""Of 255 that systems have; what writes files adds to it."""


def write_document(
    robot: Robot, folder: str | Path, name: str | None, suffix: str, text: Callable[[Robot], str]
) -> list[Path]:
    """Write a robot as one file, `<name>.<suffix>`.

    Args:
        robot: What to write.
        folder: Where to; made if it does not exist.
        name: How the file is called; the robot's name if None.
        suffix: The end of the file's name.
        text: Makes the content.

    Returns:
        The file written.

    Raises:
        RobotError: The robot has errors, or the format cannot hold it.
        InputError: The folder cannot be written, or the name cannot be a file's.
    """
    require_valid(robot)
    content = text(robot)
    return write_files(folder, {file_name(robot.name if name is None else name, suffix): content})


def file_name(stem: str, suffix: str) -> str:
    """A file's name, from what comes before and after the point; InputError as `file_stem`."""
    return f"{file_stem(stem)}.{suffix}"


def file_stem(stem: str) -> str:
    """Return a name as the part of a file's name before the point.

    Raises:
        InputError: It is empty, part of a path, or too long.
    """
    fault = stem_fault(stem)
    if fault is not None:
        raise InputError(f"{stem[:80]!r} {fault}; give another name")
    return stem


def stem_fault(stem: str) -> str | None:
    """Why no file can be called so; None if one can."""
    if not stem or any(sign in stem for sign in "/\\\0"):
        return "cannot be part of a file name"
    if len(stem.encode("utf-8", "replace")) > _MAX_BYTES:
        return f"is longer than {_MAX_BYTES} bytes, the most in a file name"
    return None


def name_losses(robot: Robot) -> Iterator[Finding]:
    """That no file can be called as the robot, for formats that do so."""
    fault = stem_fault(robot.name)
    if fault is not None:
        problem = f"its name {fault}, and its files are called so; rename it"
        yield error(Subject("robot", robot.name), "file-name", problem)
