"""Encoding of XML documents from tools that do not check it."""

from __future__ import annotations

import codecs
import re

_ENCODING = re.compile(rb"""\s*<\?xml[^>]*?encoding\s*=\s*["']([\w.-]+)""")
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE, codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE,
          b"<\0", b"\0")  # fmt: skip
_NOT_UTF8 = re.compile("[\udc80-\udcff]")  # bytes that are not UTF-8, with 0xDC00 added


def to_utf8(data: bytes) -> tuple[bytes, bool]:
    """Return a document in UTF-8 with bytes of Latin-1 repaired, and whether there were any.

    OpenSim and MuJoCo accept such bytes, for example in the names of authors.
    """
    encoding = _ENCODING.match(data)
    if data.startswith(_UTF16) or (encoding and encoding[1].lower() not in (b"utf-8", b"ascii")):
        return data, False
    text = data.decode("utf-8", "surrogateescape")
    repaired = _NOT_UTF8.sub(lambda match: chr(ord(match[0]) - 0xDC00), text)
    return repaired.encode(), repaired != text
