"""Suggestions for files that do not exist."""

from __future__ import annotations

import difflib
import os
from itertools import islice
from pathlib import Path

from addin_sdfusion.robot import CardsflowError, InputError

_MAX_NAMES = 10_000
_OUTPUT_ERRORS = ("must end in", "cannot be written")


def suggest_file(error: CardsflowError) -> str:
    """Return a suggestion for an input file that does not exist, otherwise an empty text."""
    if not isinstance(error, InputError) or error.file is None:
        return ""
    if any(words in error.problem for words in _OUTPUT_ERRORS):
        return ""
    missing = _first_missing(error.file)
    if missing is None:
        return ""
    try:
        names = [path.name for path in islice(missing.parent.iterdir(), _MAX_NAMES)]
    except OSError:
        return ""
    near = difflib.get_close_matches(missing.name, names, n=1)
    return f"; did you mean {str(missing.parent / near[0])!r}?" if near else ""


def _first_missing(file: Path) -> Path | None:
    """Return the first part of a path that does not exist."""
    parts = [*reversed(file.parents), file]
    try:
        return next((path for path in parts if not os.path.lexists(path)), None)
    except ValueError:  # a null character
        return None
