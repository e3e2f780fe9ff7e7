"""Conversion of link, joint and muscle names to parts of structured FMI variable names."""

from __future__ import annotations

import re
import unicodedata


def identifier(name: str) -> str:
    """Return a name in ASCII: `cable 1` becomes `cable_1`, `bíceps` becomes `biceps`.

    Letters without an ASCII form become `u` and their hexadecimal code point, so that different
    names in other scripts remain different.
    """
    plain = "".join(map(_ascii, unicodedata.normalize("NFKD", name))) or "_"
    return f"_{plain}" if plain[0].isdigit() else plain


def _ascii(character: str) -> str:
    if re.fullmatch(r"\w", character, re.ASCII):
        return character
    if unicodedata.combining(character) and ord(character) < 0x370:
        return ""  # an accent, which NFKD separates from its letter
    return f"u{ord(character):04x}" if re.fullmatch(r"\w", character) else "_"
