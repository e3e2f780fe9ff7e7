"""Files of single documents, and their names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ..checks.check import require_valid
from ..errors import InputError
from ..files import write_files
from ..model.robot import Robot


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
        InputError: The folder cannot be written, or the name is part of a path.
    """
    require_valid(robot)
    content = text(robot)
    return write_files(folder, {file_name(robot.name if name is None else name, suffix): content})


def file_name(stem: str, suffix: str) -> str:
    """A file's name, from what comes before and after the point; InputError as `file_stem`."""
    return f"{file_stem(stem)}.{suffix}"


def file_stem(stem: str) -> str:
    """A name as the part of a file's name before the point.

    Raises:
        InputError: It is empty or part of a path.
    """
    if not stem or any(sign in stem for sign in "/\\\0"):
        raise InputError(f"{stem!r} cannot be part of a file name; give another name")
    return stem
