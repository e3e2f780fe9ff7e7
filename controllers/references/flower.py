"""Flower and straight-line references, and sequences of references.

The flower is a planar rose curve, traversed once from rest to rest:

    y = c + R cos(k phi) (cos(phi) e1 + sin(phi) e2),   phi = phi_end s(t/T),
    s(u) = 10 u³ - 15 u⁴ + 6 u⁵,   phi_end = pi for odd k, 2 pi for even k

The curve has k petals for odd k and 2k petals for even k. It begins and ends at the tip of the
first petal, c + R e1. The CARDSFlow paper does not specify the number of petals in figure 11.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from controllers.validation import finite_vector, float_array, is_finite, require_positive

from .reference import APPROACH, ROSE, Reference, ReferencePart

_MAX_GAP = 1e-6  # largest gap between two references in a sequence, in [m] or [rad]
_MIN_DURATION, _MAX_DURATION = 1e-100, 1e100  # in [s]; squares must be representable as floats


class FlowerReference(Reference):
    """Planar rose curve in operational space, which begins and ends at rest.

    Args:
        centre: c, shape (r,), in [m].
        axes: e1 and e2, orthonormal, shape (2, r).
        radius: R, in [m].
        duration: T, in [s].
        petals: k, a positive integer: k petals if k is odd, 2k petals if k is even.

    Raises:
        InputError: A value is out of range, or the axes are not orthonormal.

    Attributes:
        name: `flower`.
        duration: T, in [s].
    """

    def __init__(
        self,
        centre: ArrayLike,
        axes: ArrayLike,
        radius: float,
        duration: float,
        petals: int = 5,
    ) -> None:
        c, e = finite_vector("centre", centre, np.size(centre)), float_array("axes", axes)
        if e.shape != (2, len(c)):
            raise InputError(f"axes must be 2 vectors of {len(c)} numbers, not {axes!r}")
        if not np.allclose(e @ e.T, np.eye(2), rtol=0.0, atol=1e-9):
            raise InputError(f"axes must be orthonormal, not {axes!r}")
        if not is_finite(petals) or petals != int(petals) or petals < 1:
            raise InputError(f"petals must be a positive integer, not {petals!r}")
        require_positive(radius=radius)
        phi_end = math.pi * (1 if petals % 2 else 2)
        data = np.concatenate([c, *e, [radius, petals, phi_end]])
        part = ReferencePart(ROSE, len(c), _checked_duration(duration), 0, 0, data)
        super().__init__("flower", [part])


class ApproachReference(Reference):
    """Minimum-jerk motion along a straight line from rest to rest: y = a + (b - a) s(t/T).

    Args:
        start: a, shape (r,), in [m] or [rad].
        end: b, shape (r,), in [m] or [rad].
        duration: T, in [s].

    Raises:
        InputError: A value is not finite, the sizes differ, or the duration is out of range.

    Attributes:
        name: `approach`.
        duration: T, in [s].
    """

    def __init__(self, start: ArrayLike, end: ArrayLike, duration: float) -> None:
        a = finite_vector("start", start, np.size(start))
        b = finite_vector("end", end, np.size(end))
        if a.shape != b.shape:
            raise InputError(f"start {start!r} and end {end!r} must have equal lengths")
        data = np.concatenate([a, b - a])
        part = ReferencePart(APPROACH, len(a), _checked_duration(duration), 0, 0, data)
        super().__init__("approach", [part])


class SequenceReference(Reference):
    """Sequence of references. The time of each reference starts at 0.

    Args:
        parts: One or more references. Each one begins at the end point of the previous one.

    Raises:
        InputError: The sequence is empty, the sizes differ, or there is a gap.

    Attributes:
        name: Names of the parts, joined by a comma.
        duration: Sum of the durations, in [s].
    """

    def __init__(self, parts: Sequence[Reference]) -> None:
        if not parts:
            raise InputError("a sequence requires at least one reference")
        for number, (before, after) in enumerate(pairwise(parts), 1):
            end, begin = before.evaluate(before.duration).q, after.evaluate(0.0).q
            if end.shape != begin.shape or np.abs(end - begin).max() > _MAX_GAP:
                raise InputError(
                    f"part {number} of the sequence ends at {end}, the next begins at {begin}"
                )
        name = ", ".join(part.name for part in parts)
        super().__init__(name, [part for reference in parts for part in reference.parts])


def _checked_duration(duration: float) -> float:
    require_positive(duration=duration)
    if not _MIN_DURATION <= duration <= _MAX_DURATION:
        allowed = f"between {_MIN_DURATION!r} and {_MAX_DURATION!r} s"
        raise InputError(f"duration must be {allowed}, not {duration!r}")
    return float(duration)
