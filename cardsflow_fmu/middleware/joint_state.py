"""The bytes of `sensor_msgs/JointState`, read and written one at a time."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray

_HEADER = 4
_STAMP = 8
_LITTLE, _BIG = b"\x00\x01", b"\x00\x00"
_MOST_NAMES = 4096


class JointState(NamedTuple):
    """A message.

    Attributes:
        time_ns: Its stamp, in [ns].
        frame: Its frame.
        names: Of its joints.
        position, velocity, effort: Shape (n,) each; (0,) where they are left out.
    """

    time_ns: int
    frame: str
    names: tuple[str, ...]
    position: FloatArray
    velocity: FloatArray
    effort: FloatArray


class JointStateReader:
    """Reads messages; names that are those of the message before are not read again."""

    def __init__(self) -> None:
        self._before = b""
        self._frame = ""
        self._names: tuple[str, ...] = ()

    def read(self, content: bytes) -> JointState | None:
        """A message; None if it is damaged.

        Args:
            content: CDR of version 1, with its header.
        """
        order = {_LITTLE: "<", _BIG: ">"}.get(content[:2])
        if order is None:
            return None
        try:
            return self._read(content, order)
        except (struct.error, ValueError):  # too short, no text
            return None

    def _read(self, content: bytes, order: str) -> JointState:
        seconds, rest = struct.unpack_from(f"{order}iI", content, _HEADER)
        place = _HEADER + _STAMP + len(self._before)
        if not self._before or content[_HEADER + _STAMP : place] != self._before:
            place = self._read_names(content, order)
        numbers = []
        for _ in range(3):
            values, place = _numbers(content, order, place)
            numbers.append(values)
        return JointState(seconds * 1_000_000_000 + rest, self._frame, self._names, *numbers)

    def _read_names(self, content: bytes, order: str) -> int:
        """Read frame and names; returns where they end."""
        self._before = b""
        frame, place = _text(content, order, _HEADER + _STAMP)
        (count,), place = _aligned(content, order, "I", place)
        if count > _MOST_NAMES:
            raise ValueError
        names = []
        for _ in range(count):
            name, place = _text(content, order, place)
            names.append(name)
        self._frame, self._names = frame, tuple(names)
        self._before = content[_HEADER + _STAMP : place]
        return place


class JointStateWriter:
    """Writes messages of the same names.

    Args:
        names: Of the joints.
        frame: Of the messages.
        position, velocity, effort: Whether the messages have them.
    """

    def __init__(
        self,
        names: Sequence[str],
        frame: str = "",
        *,
        position: bool = False,
        velocity: bool = False,
        effort: bool = False,
    ) -> None:
        start = bytearray(_LITTLE + bytes(2 + _STAMP))
        _add_text(start, frame)
        start += bytes(-(len(start) - _HEADER) % 4) + struct.pack("<I", len(names))
        for name in names:
            _add_text(start, name)
        self._places: list[slice] = []
        for is_there in (position, velocity, effort):
            count = len(names) if is_there else 0
            start += bytes(-(len(start) - _HEADER) % 4) + struct.pack("<I", count)
            if count:
                start += bytes(-(len(start) - _HEADER) % 8)
            if is_there:
                self._places.append(slice(len(start), len(start) + 8 * count))
                start += bytes(8 * count)
        self._content = start

    def write(self, time_ns: int, *values: FloatArray) -> bytes:
        """The bytes of a message.

        Args:
            time_ns: Its stamp, in [ns].
            values: Those of position, velocity and effort that the messages have, shape (n,) each.
        """
        struct.pack_into("<iI", self._content, _HEADER, *divmod(time_ns, 1_000_000_000))
        for place, numbers in zip(self._places, values, strict=True):
            self._content[place] = np.ascontiguousarray(numbers, "<f8").tobytes()
        return bytes(self._content)


def _add_text(content: bytearray, text: str) -> None:
    encoded = text.encode() + b"\0"
    content += bytes(-(len(content) - _HEADER) % 4) + struct.pack("<I", len(encoded)) + encoded


def _aligned(content: bytes, order: str, kind: str, place: int) -> tuple[tuple[int, ...], int]:
    """A number at the next place that its size divides, and where it ends."""
    size = struct.calcsize(kind)
    place += -(place - _HEADER) % size
    return struct.unpack_from(order + kind, content, place), place + size


def _text(content: bytes, order: str, place: int) -> tuple[str, int]:
    (length,), place = _aligned(content, order, "I", place)
    end = place + length
    if not length or end > len(content):
        raise ValueError
    return content[place : end - 1].decode(), end


def _numbers(content: bytes, order: str, place: int) -> tuple[FloatArray, int]:
    (count,), place = _aligned(content, order, "I", place)
    if count:
        place += -(place - _HEADER) % 8
    end = place + 8 * count
    if end > len(content):
        raise ValueError
    return np.frombuffer(content, f"{order}f8", count, place), end
