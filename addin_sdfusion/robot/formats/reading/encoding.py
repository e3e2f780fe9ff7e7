"""Encoding of XML documents from tools that do not check it."""

from __future__ import annotations

import codecs
import re

_ENCODING = re.compile(rb"""\s*<\?xml[^>]*?encoding\s*=\s*["']([\w.-]+)""")
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE, codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE,
          b"<\0", b"\0")  # fmt: skip
_LATIN_1 = "cardsflow-latin-1"
"""Name of the error handler that reads bytes that are not UTF-8 as Latin-1."""


def to_utf8(data: bytes) -> tuple[bytes, bool]:
    """Return a document in UTF-8 with bytes of Latin-1 repaired, and whether there were any.

    OpenSim and MuJoCo accept such bytes, for example in the names of authors.
    """
    encoding = _ENCODING.match(data)
    if data.startswith(_UTF16) or (encoding and encoding[1].lower() not in (b"utf-8", b"ascii")):
        return data, False
    try:
        data.decode()
    except UnicodeDecodeError:
        return data.decode("utf-8", _LATIN_1).encode(), True
    return data, False


def _read_as_latin_1(error: UnicodeError) -> tuple[str, int]:
    """Decode invalid bytes; an error handler of `codecs`."""
    assert isinstance(error, UnicodeDecodeError)
    return error.object[error.start : error.end].decode("latin-1"), error.end


codecs.register_error(_LATIN_1, _read_as_latin_1)
