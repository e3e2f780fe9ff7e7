"""Parts of a muscle's path that depend on coordinates: conditional points, branches, terms."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .function import Function
from .pose import Vector3


@dataclass(frozen=True, slots=True)
class PointCondition:
    """Condition for an active via point: a coordinate is within a range.

    Outside of the range the muscle skips the point. Length and force jump at both ends of the
    range, unless `smoothing` is positive. Then the weight s of the point increases from 0 to 1
    within this distance outside of the range. The length is s times the length with the point plus
    1 - s times the length without it.

    Attributes:
        low, high: The closed range, in [rad] or [m].
        smoothing: Width of the transition outside of the range, in [rad] or [m]; 0 for a jump.
    """

    coordinate: str
    low: float
    high: float
    smoothing: float = 0.0


@dataclass(frozen=True, slots=True)
class PointMotion:
    """Motion of a via point on its link, by f(q) times an axis.

    Attributes:
        axis: Vector in the link's frame, of any length, by which f is multiplied.
        function: f, in [m] if the axis is a unit vector.
        low, high: Range of the coordinate, in [rad] or [m]. Outside of it the point does not move.
    """

    axis: Vector3
    coordinate: str
    function: Function
    low: float = -math.inf
    high: float = math.inf


@dataclass(frozen=True, slots=True)
class Branch:
    """A branch, at which a muscle's path begins again, as after a pulley that divides a tendon.

    No segment connects the preceding via point to the first point of the branch. The length of the
    branch, up to the next branch, is divided by the divisor.

    Attributes:
        point: Index of the first via point; 0 for the path up to the first other branch.
        divisor: Divisor of the length.
    """

    point: int
    divisor: float = 1.0


@dataclass(frozen=True, slots=True)
class CoordinateTerm:
    """A term of a muscle's length that is proportional to a coordinate, as in a fixed tendon.

    Attributes:
        factor: Moment arm dl/dq, in [m/rad], or dimensionless for a coordinate in [m].
    """

    coordinate: str
    factor: float
