"""Writing of single-file robots, and valid file names."""

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
"""Systems allow 255 bytes; the writing of files appends to the name."""


def write_document(
    robot: Robot, folder: str | Path, name: str | None, suffix: str, text: Callable[[Robot], str]
) -> list[Path]:
    """Write a robot to one file, `<name>.<suffix>`.

    Args:
        folder: Output folder; created if it does not exist.
        name: File name without suffix; the name of the robot if None.
        text: Function that returns the content.

    Raises:
        RobotError: The robot has errors, or the format cannot hold it.
        InputError: The folder cannot be written, or the name is not a valid file name.
    """
    require_valid(robot)
    content = text(robot)
    return write_files(folder, {file_name(robot.name if name is None else name, suffix): content})


def file_name(stem: str, suffix: str) -> str:
    """Return the file name of a stem and a suffix; raise InputError as `file_stem`."""
    return f"{file_stem(stem)}.{suffix}"


def file_stem(stem: str) -> str:
    """Return the name if it is a valid file name stem.

    Raises:
        InputError: The name is empty, contains a path separator, or is too long.
    """
    fault = invalid_stem_reason(stem)
    if fault is not None:
        raise InputError(f"{stem[:80]!r} {fault}; choose another name")
    return stem


def invalid_stem_reason(stem: str) -> str | None:
    """Return the reason why a name is not a valid file name stem, or None if it is valid."""
    if not stem or any(sign in stem for sign in "/\\\0"):
        return "cannot be part of a file name"
    if len(stem.encode("utf-8", "replace")) > _MAX_BYTES:
        return f"is longer than {_MAX_BYTES} bytes, the maximum of a file name"
    return None


def file_name_findings(robot: Robot) -> Iterator[Finding]:
    """Report a robot name that is not a valid file name, for formats that use it."""
    fault = invalid_stem_reason(robot.name)
    if fault is not None:
        problem = f"its name {fault}, but the written files use this name; rename it"
        yield error(Subject("robot", robot.name), "file-name", problem)
