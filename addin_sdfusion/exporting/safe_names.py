"""File names that every system accepts, and that stay different where case does not count."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

MAX_NAME = 50
"""So many characters are kept of a name: with four bytes each, and with what is put around them,
they stay below the 255 bytes that file systems take."""

_DEVICES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
_WINDOWS_REFUSES = frozenset('<>:"/\\|?*')


def safe_name(name: str) -> str:
    """A name as part of a file's name: letters, digits, `_` and `-`; other signs become `_`."""
    name = unicodedata.normalize("NFC", name)  # macOS and Linux spell accents differently
    kept = (sign if sign.isalnum() or sign in "_-" else "_" for sign in name)
    safe = "".join(kept)[:MAX_NAME]
    if not safe or _DEVICES.fullmatch(safe):
        safe = f"_{safe}"
    return safe


def safe_names(names: Iterable[str]) -> dict[str, str]:
    """Return a safe name for each, all different even where upper and lower case are the same.

    Args:
        names: All different; their order decides who keeps a name that two would have.
    """
    taken: set[str] = set()
    given = {}
    for name in names:
        stem = safe = safe_name(name)
        number = 2
        while safe.casefold() in taken:
            safe = f"{stem}_{number}"
            number += 1
        taken.add(safe.casefold())
        given[name] = safe
    return given


def refused_name(name: str) -> bool:
    """Return whether a system rejects the name for a folder: Windows rejects the most."""
    wrong = any(sign in _WINDOWS_REFUSES or not sign.isprintable() for sign in name)
    return wrong or name != name.rstrip(". ") or bool(_DEVICES.fullmatch(name))
