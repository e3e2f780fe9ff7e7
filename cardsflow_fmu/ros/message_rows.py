"""Fast serialisation of many messages from two messages that the package rosbags serialises."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .topics import Batch

Bytes = NDArray[np.uint8]

_BASE, _NAME = 1, 2
"""Field kinds of rosbags: 1 for numbers and strings, 2 for messages. Other kinds are sequences."""
_ZEROS = {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}
_BYTE_TYPES = ("octet", "byte", "char")
_MARK = 0x3F
"""A byte that differs from zero. Repeated, it forms a valid number of each type."""


def message_rows(store: Any, batch: Batch) -> Bytes:
    """Return the bytes of a batch of messages, shape (K, size).

    One message is serialised twice: with arrays of zeros, and with arrays of the byte `_MARK`. The
    positions where both results differ contain the arrays, in the order of the fields.
    """
    count = len(batch.time_ns)
    zero, marked = (_Prototype(store, batch.values, batch.topic.type, byte) for byte in (0, _MARK))
    rows = np.tile(zero.content, (count, 1))
    columns = [array.reshape(count, -1).view(np.uint8) for array in zero.arrays]
    rows[:, zero.content != marked.content] = np.hstack([np.zeros((count, 0), np.uint8), *columns])
    return rows


class _Prototype:
    """Message of a batch whose arrays are filled with one byte.

    Attributes:
        arrays: Arrays of the batch in the number types of the message, in the order of its fields.
    """

    def __init__(self, store: Any, values: Mapping[str, Any], kind: str, byte: int) -> None:
        self._store, self._byte = store, bytes([byte])
        self.arrays: list[NDArray[Any]] = []
        content = store.serialize_cdr(self._message(kind, values), kind)
        self.content: Bytes = np.frombuffer(content, np.uint8)

    def _message(self, name: str, values: Mapping[str, Any]) -> Any:
        """Return a message. Missing fields are zero or empty."""
        fields = self._store.get_msgdef(name).fields
        return self._store.types[name](
            **{field: self._value(kind, values.get(field)) for field, kind in fields}
        )

    def _value(self, kind: tuple[int, Any], value: Any) -> Any:
        """Return the value of a field."""
        node, of = kind
        if node == _BASE:
            if isinstance(value, np.ndarray):
                return self._numbers(of[0], value[:, np.newaxis])[0].item()
            return _ZEROS.get(of[0], 0) if value is None else value
        if node == _NAME:
            return self._message(of, value or {})
        element, count = of
        if element[0] == _BASE and element[1][0] != "string":
            if value is None:
                return np.zeros(count, _number_type(element[1][0]))
            return self._numbers(element[1][0], value)
        if isinstance(value, np.ndarray):
            points = self._numbers("float64", value.reshape(len(value), -1))
            of_point = self._store.types[element[1]]
            return [of_point(*point) for point in points.reshape(value.shape[1:]).tolist()]
        return [self._value(element, item) for item in ([None] * count if value is None else value)]

    def _numbers(self, kind: str, values: NDArray[Any]) -> NDArray[Any]:
        """Store an array, shape (K, n), and return a row, shape (n,), filled with the byte."""
        array = np.ascontiguousarray(values, _number_type(kind))
        self.arrays.append(array)
        return np.frombuffer(self._byte * array[:1].nbytes, array.dtype)


def _number_type(kind: str) -> str:
    return "uint8" if kind in _BYTE_TYPES else kind
