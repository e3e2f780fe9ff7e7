"""Bytes of many messages at once: those of one type whose texts and lengths do not change.

CDR of version 1, little-endian, as ROS 2 has it: numbers are aligned to their size, counted from
behind the header of four bytes; texts and sequences begin with their length. As all messages of a
batch have one layout, each of their fields is a column of a table of bytes.
"""

from __future__ import annotations

import functools
import struct
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .types import type_store

Bytes = NDArray[np.uint8]

_HEADER = b"\x00\x01\x00\x00"
_NUMBERS = {
    **{
        f"{sign}int{8 * size}": f"<{sign or 'i'}{size}"
        for sign in ("", "u")
        for size in (1, 2, 4, 8)
    },
    "bool": "|u1",
    "byte": "|u1",
    "octet": "|u1",
    "char": "|u1",
    "float32": "<f4",
    "float64": "<f8",
}
_STRUCTS = {
    name: struct.Struct("<" + np.dtype(kind).char.replace("l", "q").replace("L", "Q"))
    for name, kind in _NUMBERS.items()
}
_LENGTH = _STRUCTS["uint32"]
_BASE, _NAME, _ARRAY = 1, 2, 3
"""Nodes of a kind, as rosbags numbers them; what is left are sequences."""


def message_rows(name: str, values: Mapping[str, Any], count: int) -> Bytes:
    """The bytes of a batch of messages, shape (count, size).

    Args:
        name: The type, such as `sensor_msgs/msg/JointState`.
        values: Of every field: a number or an array of `count` numbers; for sequences of numbers
            an array of shape (n,) or (count, n); texts, which are the same in all messages; of
            messages, mappings, and sequences of them. A sequence of small messages of numbers
            alone, such as points, may be an array of shape (count, n, numbers). Fields left out
            are zero or empty.
        count: Number of messages.
    """
    layout = _Layout(count)
    layout.message(name, values)
    return layout.rows()


class _Layout:
    """The columns of bytes so far."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._parts: list[Bytes] = []
        self._constant = bytearray()
        self._size = 0

    def rows(self) -> Bytes:
        """All of it behind the header, shape (count, 4 + size)."""
        if not self._parts and self._count == 1:
            return np.frombuffer(_HEADER + bytes(self._constant), np.uint8)[np.newaxis]
        self._flush()
        header = np.tile(np.frombuffer(_HEADER, np.uint8), (self._count, 1))
        return np.ascontiguousarray(np.hstack([header, *self._parts]))

    def message(self, name: str, values: Mapping[str, Any]) -> None:
        """Add a message's fields."""
        for field, kind in _fields(name):
            self._field(kind, values.get(field))

    def _field(self, kind: _Kind, value: Any) -> None:
        if kind.node == _BASE:
            self._base(kind.name, value)
        elif kind.node == _NAME:
            self.message(kind.name, {} if value is None else value)
        elif kind.node == _ARRAY:
            self._items(kind.element, [None] * kind.length if value is None else value)
        else:
            items: Any = () if value is None else value
            length = _length(items) if isinstance(items, np.ndarray) else len(items)
            self._number(_LENGTH, length)
            if length:
                self._items(kind.element, items)

    def _items(self, kind: _Kind | None, items: Any) -> None:
        assert kind is not None
        if isinstance(items, np.ndarray):
            self._numbers(items, _number_type(kind))
        else:
            for item in items:
                self._field(kind, item)

    def _base(self, kind: str, value: Any) -> None:
        if kind in ("string", "wstring"):
            self._text(value or "")
        elif isinstance(value, np.ndarray):
            self._numbers(value[:, np.newaxis], _NUMBERS[kind])
        else:
            self._number(_STRUCTS[kind], 0 if value is None else value)

    def _number(self, kind: struct.Struct, value: Any) -> None:
        self._align(kind.size)
        self._add(kind.pack(value))

    def _text(self, text: str) -> None:
        encoded = text.encode() + b"\0"
        self._number(_LENGTH, len(encoded))
        self._add(encoded)

    def _numbers(self, values: NDArray[Any], kind: str) -> None:
        """Numbers of one type without gaps, shape (n,) or (count, ...)."""
        numbers = np.ascontiguousarray(values, dtype=kind)
        self._align(numbers.itemsize)
        if numbers.ndim == 1 or self._count == 1:
            self._add(numbers.tobytes())
            return
        self._flush()
        block = numbers.reshape(self._count, -1).view(np.uint8)
        self._parts.append(block)
        self._size += block.shape[1]

    def _align(self, size: int) -> None:
        if self._size % size:
            self._add(bytes(-self._size % size))

    def _add(self, constant: bytes) -> None:
        self._constant += constant
        self._size += len(constant)

    def _flush(self) -> None:
        if self._constant:
            part = np.frombuffer(bytes(self._constant), np.uint8)
            self._parts.append(np.broadcast_to(part, (self._count, len(part))))
            self._constant.clear()


class _Kind(NamedTuple):
    """The kind of a field: a number or text, a message, or many of an element."""

    node: int
    name: str = ""
    element: Any = None
    length: int = 0


@functools.cache
def _fields(name: str) -> tuple[tuple[str, _Kind], ...]:
    """The fields of a message by their names."""
    return tuple((field, _kind(kind)) for field, kind in type_store().get_msgdef(name).fields)


def _kind(kind: Any) -> _Kind:
    """A kind of rosbags as one of ours, whose nodes are whole numbers."""
    node, details = int(kind[0]), kind[1]
    if node == _BASE:
        return _Kind(node, details[0])
    if node == _NAME:
        return _Kind(node, details)
    return _Kind(node, "", _kind(details[0]), details[1])


def _length(items: NDArray[Any]) -> int:
    """Number of elements of a sequence given as an array."""
    return int(items.shape[0 if items.ndim == 1 else 1])


def _number_type(kind: _Kind) -> str:
    """The one type of the numbers in an element."""
    if kind.node == _BASE:
        return _NUMBERS[kind.name]
    kinds = {_number_type(field) for _, field in _fields(kind.name)}
    assert len(kinds) == 1, "elements of several types have gaps"
    return kinds.pop()


def stamp(time_ns: NDArray[np.int64]) -> Mapping[str, Any]:
    """Times in [ns], shape (count,), as `builtin_interfaces/msg/Time`."""
    seconds, rest = np.divmod(time_ns, 1_000_000_000)
    return {"sec": seconds, "nanosec": rest}


def header(time_ns: NDArray[np.int64], frame: str = "") -> Mapping[str, Any]:
    """Times in [ns], shape (count,), and a frame as `std_msgs/msg/Header`."""
    return {"stamp": stamp(time_ns), "frame_id": frame}
