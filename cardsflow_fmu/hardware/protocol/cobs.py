"""Consistent overhead byte stuffing (COBS): frames in a byte stream, terminated by zeros.

Each zero in a frame is replaced by the distance to the next zero. Therefore a zero in the stream
always marks the end of a frame, and a receiver that starts in the middle loses at most one frame.
"""

from __future__ import annotations

_MAX_BLOCK = 254
"""Maximum number of bytes without a zero that one distance can encode."""


def encode(frame: bytes) -> bytes:
    """Return the stuffed bytes of a frame, including the terminating zero."""
    line = bytearray()
    for stretch in frame.split(b"\0"):
        blocks = len(stretch) // _MAX_BLOCK
        for k in range(blocks):
            line.append(_MAX_BLOCK + 1)
            line += stretch[k * _MAX_BLOCK : (k + 1) * _MAX_BLOCK]
        line.append(len(stretch) - blocks * _MAX_BLOCK + 1)
        line += stretch[blocks * _MAX_BLOCK :]
    line.append(0)
    return bytes(line)


def decode(line: bytes) -> bytes | None:
    """Return the frame in the bytes between two zeros, or None if the bytes are damaged."""
    frame = bytearray()
    at = 0
    while at < len(line):
        distance = line[at]
        if distance == 0 or at + distance > len(line):
            return None
        frame += line[at + 1 : at + distance]
        at += distance
        if distance <= _MAX_BLOCK and at < len(line):
            frame.append(0)
    return bytes(frame)


class Unstuffer:
    """Decoder of a stuffed byte stream.

    Args:
        max_bytes: Maximum length of a frame. Longer frames are dropped.

    Attributes:
        damaged: Number of dropped frames.
    """

    def __init__(self, max_bytes: int) -> None:
        self._max_stuffed = max_bytes + max_bytes // _MAX_BLOCK + 2
        self._pending = bytearray()
        self._too_long = False
        self.damaged = 0

    def take(self, chunk: bytes) -> list[bytes]:
        """Process the next bytes of the stream, and return the frames that end in them."""
        frames = []
        *ended, rest = chunk.split(b"\0")
        for stretch in ended:
            self._append(stretch)
            frame = None if self._too_long else decode(bytes(self._pending))
            if frame is None:
                self.damaged += 1
            elif frame:
                frames.append(frame)
            self._pending.clear()
            self._too_long = False
        self._append(rest)
        return frames

    def _append(self, stretch: bytes) -> None:
        if len(self._pending) + len(stretch) > self._max_stuffed:
            self._too_long = True
            self._pending.clear()
        elif not self._too_long:
            self._pending += stretch
