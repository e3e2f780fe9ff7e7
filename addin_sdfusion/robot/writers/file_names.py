"""Names of written files."""

from __future__ import annotations

from ..errors import InputError


def file_name(stem: str, suffix: str) -> str:
    """A file's name.

    Args:
        stem: What comes before the point.
        suffix: What comes after it.

    Raises:
        InputError: The stem is empty or part of a path.
    """
    if not stem or any(sign in stem for sign in "/\\\0"):
        raise InputError(f"{stem!r} cannot be part of a file name; give another name")
    return f"{stem}.{suffix}"
