"""Consistent overhead byte stuffing (COBS): frames on a byte line, each ended by a zero.

Each zero of a frame is replaced by the distance to the next one, so that a zero on the line is the
end of a frame and nothing else, and a receiver that starts in the middle loses one frame at most.
"""

from __future__ import annotations

_MAX_BLOCK = 254
"""Longest stretch without a zero that one distance can encode."""


def encode(frame: bytes) -> bytes:
    """Return a frame as it goes over the line, its ending zero included."""
    line = bytearray()
    for stretch in frame.split(b"\0"):
        whole = len(stretch) // _MAX_BLOCK
        for k in range(whole):
            line.append(_MAX_BLOCK + 1)
            line += stretch[k * _MAX_BLOCK : (k + 1) * _MAX_BLOCK]
        line.append(len(stretch) - whole * _MAX_BLOCK + 1)
        line += stretch[whole * _MAX_BLOCK :]
    line.append(0)
    return bytes(line)


def decode(line: bytes) -> bytes | None:
    """Return the frame between two zeros of the line; None if it is damaged."""
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
    """A decoder of the byte stream of a line.

    Args:
        most: Longest frame, in bytes; what is longer on the line is dropped.

    Attributes:
        damaged: How many stretches between two zeros were no frame.
    """

    def __init__(self, most: int) -> None:
        self._most = most + most // _MAX_BLOCK + 2
        self._pending = bytearray()
        self._too_long = False
        self.damaged = 0

    def take(self, chunk: bytes) -> list[bytes]:
        """Return the frames that end in a chunk of bytes."""
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
        if len(self._pending) + len(stretch) > self._most:
            self._too_long = True
            self._pending.clear()
        elif not self._too_long:
            self._pending += stretch
