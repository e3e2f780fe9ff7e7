"""What all references are: parts one after another, evaluated by csrc/references."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from controllers.arrays import FloatArray
from controllers.qp import dual_newton

SPLINES, ROSE, APPROACH = range(3)
"""Kinds of parts: `reference_kind` of csrc/references/references.h."""

_P, _SIZE = ctypes.c_void_p, ctypes.c_size_t


class JointReference(NamedTuple):
    """A point of a reference, or its points at k times.

    Attributes:
        q: Positions, shape (n,) or (k, n), in [rad] or [m].
        qd: Velocities, shape (n,) or (k, n), in [rad/s] or [m/s].
        qdd: Accelerations, shape (n,) or (k, n), in [rad/s²] or [m/s²].
    """

    q: FloatArray
    qd: FloatArray
    qdd: FloatArray


class ReferencePart(NamedTuple):
    """A part of a reference: a spline, a rose, or an approach.

    Attributes:
        kind: One of the constants above.
        r: Number of rows: coordinates, or task coordinates.
        duration: In [s].
        segments, powers: Of splines, else 0.
        data: The numbers of the part, in the order of csrc/references/references.h.
    """

    kind: int
    r: int
    duration: float
    segments: int
    powers: int
    data: FloatArray


class _Part(ctypes.Structure):
    """`reference_part` of csrc/references/references.h."""

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
    references.reference_evaluate.argtypes = [_P, _P, _SIZE, _SIZE, _P, _P]
    references.reference_evaluate.restype = None
    return references


class Reference:
    """A motion in time, defined for every t; its points are (y, yd, ydd) or (q, qd, qdd).

    Args:
        name: Its name.
        parts: Its parts, at least one, all of the same size.

    Attributes:
        name: Its name.
        duration: The sum of the parts' durations, in [s].
        parts: The parts.
        begins: When each part begins, in [s].
    """

    def __init__(self, name: str, parts: Sequence[ReferencePart]) -> None:
        self.name, self.parts = name, tuple(parts)
        ends = np.cumsum([part.duration for part in self.parts])
        self.begins = [0.0, *ends[:-1].tolist()]
        self.duration = float(ends[-1])

    def evaluate(self, t: ArrayLike) -> JointReference:
        """Return the reference at a time, or at several; at rest before 0 and after its duration.

        Args:
            t: Time, in [s]: a number, or an array of shape (k,).

        Returns:
            Positions, velocities and accelerations, shape (n,) each, or (k, n).
        """
        times, begins = np.asarray(t, dtype=float, order="C"), np.array(self.begins)
        rows = np.empty((*times.shape, 3, self.parts[0].r))
        parts = [_Part(*part[:-1], part.data.ctypes.data) for part in self.parts]
        _library().reference_evaluate(
            (_Part * len(parts))(*parts),
            begins.ctypes.data,
            len(parts),
            times.size,
            times.ctypes.data,
            rows.ctypes.data,
        )
        return JointReference(*rows.swapaxes(0, -2))
