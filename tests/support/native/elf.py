"""Sizes and symbol names of programs for a microcontroller."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple


class Sizes(NamedTuple):
    """Sizes of a program by memory region, in bytes."""

    code: int
    constants: int
    memory: int


def program_sizes(program: Path) -> Sizes:
    """Return the sizes of a 32-bit ELF program, from its section headers."""
    sums = {"code": 0, "constants": 0, "memory": 0}
    for _, kind, flags, _, _, length, *_ in _sections(program.read_bytes()):
        if not flags & 2:  # not loaded into memory
            continue
        where = "code" if flags & 4 else "memory" if flags & 1 or kind == 8 else "constants"
        sums[where] += length
    return Sizes(**sums)


def program_names(program: Path) -> set[str]:
    """Return the names of functions and data in a 32-bit ELF program, from its symbol table."""
    image = program.read_bytes()
    sections = list(_sections(image))
    names = set()
    for _, kind, _, _, at, length, link, *_ in sections:
        if kind != 2:  # no symbol table
            continue
        texts = image[sections[link][4] :]
        for symbol in struct.iter_unpack("<3I2BH", image[at : at + length]):
            names.add(texts[symbol[0] : texts.index(b"\0", symbol[0])].decode())
    return names - {""}


def _sections(image: bytes) -> Iterator[tuple[int, ...]]:
    """Yield the section headers."""
    assert image[:5] == b"\x7fELF\x01"
    table = struct.unpack_from("<I", image, 32)[0]
    size, count = struct.unpack_from("<2H", image, 46)
    return (struct.unpack_from("<10I", image, table + k * size) for k in range(count))
