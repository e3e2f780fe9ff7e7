"""Binding of the references in C: one part of a reference, evaluated at any times."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from controllers.arrays import FloatArray
from controllers.qp import dual_newton

SPLINES, ROSE, APPROACH = range(3)
"""Kinds of parts: `reference_kind` of csrc/references/reference.h."""

_P, _SIZE = ctypes.c_void_p, ctypes.c_size_t


class _Part(ctypes.Structure):
    """`reference_part` of csrc/references/reference.h."""

    _fields_ = (
        ("kind", _SIZE),
        ("r", _SIZE),
        ("duration", ctypes.c_double),
        ("segments", _SIZE),
        ("powers", _SIZE),
        ("data", _P),
    )


@cache
def _library() -> ctypes.PyDLL:
    references = dual_newton.library()
    references.reference_evaluate.argtypes = [ctypes.POINTER(_Part), _SIZE, _P, _P]
    references.reference_evaluate.restype = None
    return references


class ReferencePart:
    """A part of a reference: a spline, a rose, or an approach.

    Args:
        kind: One of the constants above.
        r: Number of rows: coordinates, or task coordinates.
        duration: In [s].
        data: The numbers of the part, in the order of csrc/references/reference.h.
        segments, powers: Of splines.

    Attributes:
        kind, duration, data, segments, powers: As given; `data` is one array.
    """

    def __init__(
        self,
        kind: int,
        r: int,
        duration: float,
        data: Sequence[ArrayLike],
        segments: int = 0,
        powers: int = 0,
    ) -> None:
        self.kind, self.duration = kind, float(duration)
        self.segments, self.powers = segments, powers
        self.data: FloatArray = np.concatenate([np.ravel(numbers) for numbers in data], dtype=float)
        self._r = r
        self._part = _Part(kind, r, self.duration, segments, powers, self.data.ctypes.data)

    def at(self, times: FloatArray) -> FloatArray:
        """Positions, velocities and accelerations at times in [s]; shape (len(times), 3, r)."""
        rows = np.empty((len(times), 3, self._r))
        _library().reference_evaluate(self._part, len(times), times.ctypes.data, rows.ctypes.data)
        return rows

    def __reduce__(self) -> tuple[object, ...]:  # the structure holds an address
        sizes = self.segments, self.powers
        return ReferencePart, (self.kind, self._r, self.duration, [self.data], *sizes)
