"""Bytes of many messages at once: those of one type whose texts and lengths do not change.

CDR of version 1, little-endian, as ROS 2 has it: numbers are aligned to their size, counted from
behind the header of four bytes; texts and sequences begin with their length. As all messages of a
batch have one layout, each of their fields is a column of a table of bytes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

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
        self._flush()
        header = np.tile(np.frombuffer(_HEADER, np.uint8), (self._count, 1))
        return np.ascontiguousarray(np.hstack([header, *self._parts]))

    def message(self, name: str, values: Mapping[str, Any]) -> None:
        """Add a message's fields."""
        for field, kind in type_store().get_msgdef(name).fields:
            self._field(kind, values.get(field))

    def _field(self, kind: Any, value: Any) -> None:
        from rosbags.interfaces import Nodetype

        node, details = kind
        if node == Nodetype.BASE:
            self._base(details[0], value)
        elif node == Nodetype.NAME:
            self.message(details, {} if value is None else value)
        elif node == Nodetype.ARRAY:
            self._items(details[0], [None] * details[1] if value is None else value)
        else:
            items: Any = () if value is None else value
            length = _length(items) if isinstance(items, np.ndarray) else len(items)
            self._base("uint32", length)
            if length:
                self._items(details[0], items)

    def _items(self, kind: Any, items: Any) -> None:
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
            number = np.dtype(_NUMBERS[kind]).type(0 if value is None else value)
            self._align(number.itemsize)
            self._add(number.tobytes())

    def _text(self, text: str) -> None:
        encoded = text.encode() + b"\0"
        self._base("uint32", len(encoded))
        self._add(encoded)

    def _numbers(self, values: NDArray[Any], kind: str) -> None:
        """Numbers of one type without gaps, shape (n,) or (count, ...)."""
        numbers = np.ascontiguousarray(values, dtype=kind)
        self._align(numbers.itemsize)
        if numbers.ndim == 1:
            self._add(numbers.tobytes())
            return
        self._flush()
        block = numbers.reshape(self._count, -1).view(np.uint8)
        self._parts.append(block)
        self._size += block.shape[1]

    def _align(self, size: int) -> None:
        self._add(bytes(-self._size % size))

    def _add(self, constant: bytes) -> None:
        self._constant += constant
        self._size += len(constant)

    def _flush(self) -> None:
        if self._constant:
            part = np.frombuffer(bytes(self._constant), np.uint8)
            self._parts.append(np.broadcast_to(part, (self._count, len(part))))
            self._constant.clear()


def _length(items: NDArray[Any]) -> int:
    """Number of elements of a sequence given as an array."""
    return int(items.shape[0 if items.ndim == 1 else 1])


def _number_type(kind: Any) -> str:
    """The one type of the numbers in an element."""
    from rosbags.interfaces import Nodetype

    node, details = kind
    if node == Nodetype.BASE:
        return _NUMBERS[details[0]]
    kinds = {_number_type(field) for _, field in type_store().get_msgdef(details).fields}
    assert len(kinds) == 1, "elements of several types have gaps"
    return kinds.pop()


def stamp(time_ns: NDArray[np.int64]) -> Mapping[str, Any]:
    """Times in [ns], shape (count,), as `builtin_interfaces/msg/Time`."""
    seconds, rest = np.divmod(time_ns, 1_000_000_000)
    return {"sec": seconds, "nanosec": rest}


def header(time_ns: NDArray[np.int64], frame: str = "") -> Mapping[str, Any]:
    """Times in [ns], shape (count,), and a frame as `std_msgs/msg/Header`."""
    return {"stamp": stamp(time_ns), "frame_id": frame}
