"""References in operational space: a flower, a straight approach, and sequences of references.

The flower is a rose in a plane, drawn once from rest to rest:

    y = c + R cos(k phi) (cos(phi) e1 + sin(phi) e2),   phi = phi_end s(t/T),
    s(u) = 10 u³ - 15 u⁴ + 6 u⁵,   phi_end = pi for odd k, 2 pi for even k

With odd k it has k petals, with even k 2k. It begins and ends at the tip of the first, c + R e1.
The CARDSFlow paper's figure 11 does not say which flower it draws.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from controllers.validation import finite_vector, float_array, is_finite, require_positive

from .splines import JointReference

_GAP = 1e-6  # the largest gap between two references in a sequence, in [m] or [rad]
_SHORTEST, _LONGEST = 1e-100, 1e100  # durations in [s] whose squares are numbers


class Reference(Protocol):
    """A motion in time, defined for every t; its points are (y, yd, ydd) or (q, qd, qdd)."""

    @property
    def duration(self) -> float: ...  # noqa: D102

    def evaluate(self, t: float) -> JointReference:
        """The reference at a time in [s]; at rest before 0 and after its duration."""


class FlowerReference:
    """A rose in a plane of the operational space, at rest before and after.

    Args:
        centre: c, shape (r,), in [m].
        axes: e1 and e2, orthonormal, shape (2, r).
        radius: R, in [m].
        duration: T, in [s].
        petals: k, a whole number: k petals if it is odd, 2k if it is even.

    Raises:
        InputError: A value is out of range, or the axes are not orthonormal.

    Attributes:
        name: `flower`.
        duration: T, in [s].
    """

    name = "flower"

    def __init__(
        self,
        centre: ArrayLike,
        axes: ArrayLike,
        radius: float,
        duration: float,
        petals: int = 5,
    ) -> None:
        self._c = finite_vector("centre", centre, np.size(centre))
        self._e = float_array("axes", axes)
        if self._e.shape != (2, len(self._c)):
            raise InputError(f"axes must be 2 vectors as long as the centre, not {axes!r}")
        if not np.allclose(self._e @ self._e.T, np.eye(2), rtol=0.0, atol=1e-9):
            raise InputError(f"axes must be orthonormal, not {axes!r}")
        if not is_finite(petals) or petals != int(petals) or petals < 1:
            raise InputError(f"petals must be a whole number from 1 on, not {petals!r}")
        require_positive(radius=radius)
        self._R, self.duration = float(radius), _checked_duration(duration)
        self._k = int(petals)
        self._end = math.pi * (1 if self._k % 2 else 2)

    def evaluate(self, t: float) -> JointReference:
        """y, yd and ydd at a time, shape (r,) each, in [m], [m/s] and [m/s²].

        Args:
            t: Time, in [s].
        """
        phi, phid, phidd = (self._end * x for x in _quintic(t, self.duration))
        k = self._k
        u = math.cos(phi) * self._e[0] + math.sin(phi) * self._e[1]
        v = math.cos(phi) * self._e[1] - math.sin(phi) * self._e[0]
        r, rp = self._R * math.cos(k * phi), -self._R * k * math.sin(k * phi)
        first = rp * u + r * v  # dy/dphi, with u' = v, v' = -u, r'' = -k² r
        second = -(k * k + 1) * r * u + 2.0 * rp * v
        return JointReference(self._c + r * u, first * phid, second * phid**2 + first * phidd)


class ApproachReference:
    """A straight line from rest to rest, of minimum jerk: y = a + (b - a) s(t/T).

    Args:
        start: a, shape (r,), in [m] or [rad].
        end: b, shape (r,).
        duration: T, in [s].

    Raises:
        InputError: A value is not finite, the sizes differ, or the duration is out of range.

    Attributes:
        name: `approach`.
        duration: T, in [s].
    """

    name = "approach"

    def __init__(self, start: ArrayLike, end: ArrayLike, duration: float) -> None:
        self._start = finite_vector("start", start, np.size(start))
        b = finite_vector("end", end, np.size(end))
        if self._start.shape != b.shape:
            raise InputError(f"start {start!r} and end {end!r} must be equally long")
        self._way = b - self._start
        self.duration = _checked_duration(duration)

    def evaluate(self, t: float) -> JointReference:
        """y, yd and ydd at a time, shape (r,) each.

        Args:
            t: Time, in [s].
        """
        s, sd, sdd = _quintic(t, self.duration)
        return JointReference(self._start + s * self._way, sd * self._way, sdd * self._way)


class SequenceReference:
    """References one after another, each with its own time from 0 on.

    Args:
        parts: The references, at least one; each begins where the one before ends.

    Raises:
        InputError: There is none, the sizes differ, or there is a gap.

    Attributes:
        name: The parts' names, joined by a comma.
        duration: The sum of the parts' durations, in [s].
        begins: When each part begins, in [s].
    """

    def __init__(self, parts: Sequence[Reference]) -> None:
        if not parts:
            raise InputError("a sequence needs at least one reference")
        self._parts = tuple(parts)
        for number, (before, after) in enumerate(pairwise(self._parts), 1):
            end, begin = before.evaluate(before.duration).q, after.evaluate(0.0).q
            if end.shape != begin.shape or np.abs(end - begin).max() > _GAP:
                raise InputError(
                    f"part {number} of the sequence ends at {end}, the next begins at {begin}"
                )
        ends = np.cumsum([part.duration for part in self._parts])
        self.begins = [0.0, *ends[:-1].tolist()]
        self.duration = float(ends[-1])
        self.name = ", ".join(getattr(part, "name", "unnamed") for part in self._parts)

    def evaluate(self, t: float) -> JointReference:
        """The part whose turn it is, at its own time.

        Args:
            t: Time, in [s].
        """
        k = max(bisect.bisect_right(self.begins, t) - 1, 0)
        return self._parts[k].evaluate(t - self.begins[k])


def _checked_duration(duration: float) -> float:
    require_positive(duration=duration)
    if not _SHORTEST <= duration <= _LONGEST:
        what = f"must be within {_SHORTEST!r} and {_LONGEST!r} s"
        raise InputError(f"duration {what}, not {duration!r}")
    return float(duration)


def _quintic(t: float, duration: float) -> tuple[float, float, float]:
    """s, s' and s'' of the quintic from 0 to 1; at rest before 0 and after the duration."""
    if t <= 0.0:
        return 0.0, 0.0, 0.0
    if t >= duration:
        return 1.0, 0.0, 0.0
    u = t / duration
    s = u**3 * (10.0 + u * (6.0 * u - 15.0))
    sd = 30.0 * u**2 * (1.0 - u) ** 2 / duration
    sdd = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / duration**2
    return s, sd, sdd
