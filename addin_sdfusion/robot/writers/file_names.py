"""Names of written files."""

from __future__ import annotations

from ..errors import InputError


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
