"""Selection of columns by patterns."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase

from addin_sdfusion.robot import UnknownNameError


def chosen_columns(names: Sequence[str], patterns: Sequence[str]) -> list[str]:
    """Return the names that match a pattern, without `time`.

    Raises:
        UnknownNameError: A pattern matches no name.
    """
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in names):
            raise UnknownNameError("column", pattern, names, key="--columns")
    return [n for n in names if n != "time" and any(fnmatchcase(n, p) for p in patterns)]
