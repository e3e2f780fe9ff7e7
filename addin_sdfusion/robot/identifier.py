"""Names of links, joints and muscles as parts of FMI's structured names of variables."""

from __future__ import annotations

import re
import unicodedata


def identifier(name: str) -> str:
    """A name in ASCII: `cable 1` as `cable_1`, `bíceps` as `biceps`, other scripts by their codes.

    Letters without an ASCII form are `u` and their code point in hexadecimal digits, so that names
    in one script stay different.
    """
    plain = "".join(map(_ascii, unicodedata.normalize("NFKD", name))) or "_"
    return f"_{plain}" if plain[0].isdigit() else plain


def _ascii(character: str) -> str:
    if re.fullmatch(r"\w", character, re.ASCII):
        return character
    if unicodedata.combining(character) and ord(character) < 0x370:
        return ""  # an accent, apart from its letter
    return f"u{ord(character):04x}" if re.fullmatch(r"\w", character) else "_"
