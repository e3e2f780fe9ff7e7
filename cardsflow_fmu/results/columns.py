"""Columns chosen by patterns of names."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase

from addin_sdfusion.robot import UnknownNameError


def chosen_columns(
    names: Sequence[str], patterns: Sequence[str], key: str = "--columns"
) -> list[str]:
    """The names that fit one of the patterns, without `time`.

    Args:
        names: Names of columns.
        patterns: Such as `q.*`, or a name.
        key: For the message.

    Raises:
        UnknownNameError: A pattern fits none.
    """
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in names):
            raise UnknownNameError("column", pattern, names, key=key)
    return [n for n in names if n != "time" and any(fnmatchcase(n, p) for p in patterns)]
