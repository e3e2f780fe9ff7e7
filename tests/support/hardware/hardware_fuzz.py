"""Invalid frames: random frames, damaged frames, and old frames of other runs."""

from __future__ import annotations

import math
import os
import random
import struct
import zlib
from collections.abc import Iterator, Sequence

FRAMES = int(os.environ.get("CARDSFLOW_HARDWARE_FRAMES", "2000"))
"""Number of frames per test; 1000000 in long test runs."""

SPECIAL = [math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, 0.0, -1.0, 1e9, 2.0**32, 2.0**63]


def with_checksum(frame: bytes, *, signed: bool = False) -> bytes:
    """Return a frame of at least 48 bytes with a valid checksum, as the protocol defines it."""
    end = max(len(frame) - 32, 48) if signed else len(frame)
    head, body, tail = frame[:44], frame[48:end], frame[end:]
    return head + struct.pack("<I", zlib.crc32(head + bytes(4) + body)) + body + tail


def bad_frames(samples: Sequence[bytes], count: int, seed: int) -> Iterator[bytes]:
    """Yield a number of random frames and damaged valid frames."""
    chance = random.Random(seed)
    ways = [_random, _flipped, _flipped_and_summed, _cut, _stretched, _strange_values, _header]
    for _ in range(count):
        frame = chance.choice(ways)(chance.choice(samples), chance)
        if frame not in samples:
            yield frame


def _random(sample: bytes, chance: random.Random) -> bytes:
    return chance.randbytes(chance.choice([0, 1, 47, 48, 49, 56, 72, 80, chance.randrange(2000)]))


def _flipped(sample: bytes, chance: random.Random) -> bytes:
    frame = bytearray(sample)
    for _ in range(chance.randint(1, 4)):
        frame[chance.randrange(len(frame))] ^= 1 << chance.randrange(8)
    return bytes(frame)


def _flipped_and_summed(sample: bytes, chance: random.Random) -> bytes:
    return _summed(_flipped(sample, chance))


def _cut(sample: bytes, chance: random.Random) -> bytes:
    return sample[: chance.randrange(len(sample))]


def _stretched(sample: bytes, chance: random.Random) -> bytes:
    return sample + chance.randbytes(chance.choice([1, 7, 8, 16, 32, 40, 65000 - len(sample)]))


def _strange_values(sample: bytes, chance: random.Random) -> bytes:
    count = struct.unpack_from("<H", sample, 40)[0]
    frame = bytearray(sample)
    for _ in range(chance.randint(1, 3)):
        if count:
            struct.pack_into("<d", frame, 48 + 8 * chance.randrange(count), chance.choice(SPECIAL))
    if chance.random() < 0.2:
        struct.pack_into("<d", frame, 16, chance.choice(SPECIAL))
    return _summed(bytes(frame))


def _header(sample: bytes, chance: random.Random) -> bytes:
    """Return a frame with changed header fields and a valid checksum."""
    frame = bytearray(sample)
    form, at = chance.choice([("B", 4), ("B", 5), ("H", 6), ("I", 8), ("I", 12), ("H", 40)])
    most = 256 ** struct.calcsize(form) - 1
    value = chance.choice([0, 1, 2, 3, most, most // 2 + 1, chance.randint(0, most)])
    struct.pack_into(f"<{form}", frame, at, min(value, most))
    return _summed(bytes(frame))


def _summed(frame: bytes) -> bytes:
    signed = len(frame) >= 80 and frame[6] & 1
    return with_checksum(frame, signed=bool(signed)) if len(frame) >= 48 else frame
