"""Sizes of programs for a microcontroller."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import NamedTuple


class Sizes(NamedTuple):
    """Bytes of a program, by where they go."""

    code: int
    constants: int
    memory: int


def program_sizes(program: Path) -> Sizes:
    """Sizes of a 32-bit ELF program, from its section headers."""
    image = program.read_bytes()
    assert image[:5] == b"\x7fELF\x01"
    table, size, count = (
        struct.unpack_from("<I", image, 32)[0],
        *struct.unpack_from("<2H", image, 46),
    )
    sums = {"code": 0, "constants": 0, "memory": 0}
    for k in range(count):
        _, kind, flags, _, _, length = struct.unpack_from("<6I", image, table + k * size)
        if not flags & 2:  # takes no memory on the machine
            continue
        where = "code" if flags & 4 else "memory" if flags & 1 or kind == 8 else "constants"
        sums[where] += length
    return Sizes(**sums)
