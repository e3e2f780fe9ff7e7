"""Parts of a muscle's path that depend on coordinates: conditional points, branches, terms."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .function import Function
from .pose import Vector3


@dataclass(frozen=True, slots=True)
class PointCondition:
    """When a muscle passes through a via point: while a coordinate is within a range.

    Elsewhere the muscle goes straight on to the next point. Length and force jump at both ends of
    the range, unless there is a smoothing: then the share s of the point rises from 0 to 1 within
    that distance outside of the range, and the length is s times that with the point and 1 - s
    times that without it.

    Attributes:
        coordinate: Name of the coordinate.
        low, high: The range, ends included, in [rad] or [m].
        smoothing: Over how far the change goes on outside of the range, in [rad] or [m]; 0: a jump.
    """

    coordinate: str
    low: float
    high: float
    smoothing: float = 0.0


@dataclass(frozen=True, slots=True)
class PointMotion:
    """How a coordinate moves a via point on its link: by f(q) along an axis.

    Attributes:
        axis: In the link's frame; a vector of any length, by which f counts.
        coordinate: Name of the coordinate.
        function: f, in [m] where the axis is a unit vector.
        low, high: Beyond these values of the coordinate the point stands still, in [rad] or [m].
    """

    axis: Vector3
    coordinate: str
    function: Function
    low: float = -math.inf
    high: float = math.inf


@dataclass(frozen=True, slots=True)
class Branch:
    """Where a muscle's path begins again, as behind a pulley that divides a tendon.

    There is no segment between the via point before and this one. The length of the branch, up to
    the next one, counts divided.

    Attributes:
        point: Index of the via point that it begins with; 0 for the whole path up to the next.
        divisor: What its length is divided by.
    """

    point: int
    divisor: float = 1.0


@dataclass(frozen=True, slots=True)
class CoordinateTerm:
    """A part of a muscle's length that is proportional to a coordinate, as of a fixed tendon.

    Attributes:
        coordinate: Name of the coordinate.
        factor: The moment arm dl/dq, in [m/rad], or without unit for one in [m].
    """

    coordinate: str
    factor: float
