"""File names that all systems accept, unique also on case-insensitive file systems."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

MAX_NAME = 50
"""Maximum number of characters of a name. With four bytes per character and a prefix and suffix,
names are shorter than the limit of file systems, 255 bytes."""

_DEVICES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
_WINDOWS_INVALID = frozenset('<>:"/\\|?*')


def safe_name(name: str) -> str:
    """Return a name for use in a file name; all but letters, digits, `_` and `-` become `_`."""
    name = unicodedata.normalize("NFC", name)  # macOS and Linux encode accents differently
    allowed = (sign if sign.isalnum() or sign in "_-" else "_" for sign in name)
    safe = "".join(allowed)[:MAX_NAME]
    if not safe or _DEVICES.fullmatch(safe):
        safe = f"_{safe}"
    return safe


def safe_names(names: Iterable[str]) -> dict[str, str]:
    """Return safe names that are unique also on case-insensitive file systems.

    Args:
        names: Unique names. If two safe names are equal, the first name keeps it.
    """
    used: set[str] = set()
    safe_of = {}
    for name in names:
        stem = safe = safe_name(name)
        number = 2
        while safe.casefold() in used:
            safe = f"{stem}_{number}"
            number += 1
        used.add(safe.casefold())
        safe_of[name] = safe
    return safe_of


def is_unsafe_name(name: str) -> bool:
    """Return whether an operating system, such as Windows, rejects a folder name."""
    wrong = any(sign in _WINDOWS_INVALID or not sign.isprintable() for sign in name)
    return wrong or name != name.rstrip(". ") or bool(_DEVICES.fullmatch(name))
