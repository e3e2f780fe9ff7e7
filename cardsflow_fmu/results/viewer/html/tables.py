"""Compressed tables of numbers.

Each table is scaled to 16-bit integers between its minimum and maximum. It is stored column by
column as differences between rows, and compressed with deflate. The differences are small because
successive frames are similar.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

_LEVELS = 0xFFFF


class TableSequence:
    """Sequence of tables of 16-bit integers."""

    def __init__(self) -> None:
        self._parts: list[NDArray[np.uint16]] = []
        self._size = 0

    def add(self, values: ArrayLike, *, exact: bool = False) -> dict[str, Any]:
        """Add a table and return its entry in the header; only one of equal rows is stored.

        Args:
            values: Table, shape (rows, columns).
            exact: Whether the values are integers from 0 to 65535, which are not scaled.
        """
        table = np.asarray(values, dtype=np.float64)
        if len(table) > 1 and not exact and (table == table[0]).all():
            table = table[:1]
        low, high = (0.0, float(_LEVELS)) if exact else _bounds(table)
        scaled = np.rint((table - low) * (_LEVELS / (high - low)))
        numbers = np.nan_to_num(scaled).clip(0, _LEVELS).astype(np.uint16)
        differences = np.diff(numbers, axis=0, prepend=np.zeros_like(numbers[:1]))  # modulo 65536
        entry = {"at": self._size, "rows": len(table), "low": low, "high": high}
        self._parts.append(differences.T.reshape(-1))
        self._size += differences.size
        return entry | {"columns": table.shape[1]}

    def encode(self) -> bytes:
        """Return all low bytes, then all high bytes. High bytes are mostly 0 or 255."""
        numbers = np.concatenate(self._parts) if self._parts else np.zeros(0, np.uint16)
        low, high = (numbers & 0xFF).astype(np.uint8), (numbers >> 8).astype(np.uint8)
        return low.tobytes() + high.tobytes()


def _bounds(table: NDArray[np.float64]) -> tuple[float, float]:
    finite = table[np.isfinite(table)]
    if not finite.size:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    return low, high if high > low else low + 1.0
