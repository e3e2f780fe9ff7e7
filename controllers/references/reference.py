"""Base class of references: sequences of parts, evaluated by csrc/references."""

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
"""Kinds of parts: the C enumeration `reference_kind` in csrc/references/references.h."""

_P, _SIZE = ctypes.c_void_p, ctypes.c_size_t


class JointReference(NamedTuple):
    """One point of a reference, or points at k times.

    Attributes:
        q: Positions, shape (n,) or (k, n), in [rad] or [m].
        qd: Velocities, shape (n,) or (k, n), in [rad/s] or [m/s].
        qdd: Accelerations, shape (n,) or (k, n), in [rad/s²] or [m/s²].
    """

    q: FloatArray
    qd: FloatArray
    qdd: FloatArray


class ReferencePart(NamedTuple):
    """Part of a reference: a spline, a rose curve, or an approach.

    Attributes:
        kind: SPLINES, ROSE or APPROACH.
        r: Number of coordinates, or of task coordinates.
        duration: Duration, in [s].
        segments, powers: Number of segments and of powers of a spline; 0 for other parts.
        data: Numbers of the part, in the order of csrc/references/references.h.
    """

    kind: int
    r: int
    duration: float
    segments: int
    powers: int
    data: FloatArray


class _Part(ctypes.Structure):
    """The C structure `reference_part` in csrc/references/references.h."""

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
    """Reference motion, defined for every t. Its points are (y, yd, ydd) or (q, qd, qdd).

    Args:
        parts: One or more parts of the same size.

    Attributes:
        duration: Sum of the durations of the parts, in [s].
        begins: Start times of the parts, in [s].
    """

    def __init__(self, name: str, parts: Sequence[ReferencePart]) -> None:
        self.name, self.parts = name, tuple(parts)
        ends = np.cumsum([part.duration for part in self.parts])
        self.begins = [0.0, *ends[:-1].tolist()]
        self.duration = float(ends[-1])

    def evaluate(self, t: ArrayLike) -> JointReference:
        """Return the reference at one or several times.

        The reference is at rest before 0 and after its duration.

        Args:
            t: Time, in [s]: a number, or an array of shape (k,).

        Returns:
            Positions, velocities and accelerations, each of shape (n,) or (k, n).
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
