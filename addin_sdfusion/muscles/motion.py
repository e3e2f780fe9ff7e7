"""Lengths and moment arms of muscles while one joint moves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ..robot.model.joint import Coordinate
from ..robot.model.link_poses import link_poses
from ..robot.model.robot import Robot
from ..robot.model.transform import Transform
from .path import MusclePath, path_of
from .table import MuscleTable

SAMPLES = 13
"""Number of positions of the plot over the range."""
_STEP = 1e-5  # of the central difference, in [rad] or [m]
_UNLIMITED = {"rad": math.pi, "m": 0.1}
_POSITIVE, _NEGATIVE, _ZERO = (214, 39, 40), (31, 119, 180), (190, 190, 190)
_BARS = "▁▂▃▄▅▆▇█"


@dataclass(frozen=True, slots=True)
class MuscleMotion:
    """A muscle at one position of a joint.

    Attributes:
        path: The path at this position.
        change: Change of length since the pose of the design, in [m].
        arm: Moment arm -dl/dq, in [m], or dimensionless for a sliding coordinate.
        arms: Moment arms at `SAMPLES` positions from the lower to the upper end of the range.
    """

    path: MusclePath
    change: float
    arm: float
    arms: tuple[float, ...]

    @property
    def plot(self) -> str:
        """The moment arms over the range as bars, from the smallest to the largest one."""
        low, high = min(self.arms), max(self.arms)
        if high - low <= 1e-9:
            return _BARS[0] * len(self.arms)
        scale = (len(_BARS) - 1) / (high - low)
        return "".join(_BARS[round(scale * (arm - low))] for arm in self.arms)


@dataclass
class JointSweep:
    """Motion of a robot about or along one coordinate; the others keep the pose of the design.

    Attributes:
        robot: Robot whose world frame is the root frame of the design. Muscles, masses and loops
            are not used.
        coordinate: The coordinate that moves.
    """

    robot: Robot
    coordinate: Coordinate
    _moved: dict[float, Mapping[str, Transform]] = field(default_factory=dict)
    _table: MuscleTable | None = None
    _arms: dict[str, tuple[float, ...]] = field(default_factory=dict)

    def range(self) -> tuple[float, float]:
        """Return the limits, in [rad] or [m]; ±180° or ±100 mm about the pose if unlimited."""
        return self.coordinate.range(_UNLIMITED[self.coordinate.unit])

    def muscle(self, table: MuscleTable, muscle: str, q: float) -> MuscleMotion:
        """Return a muscle at a value of the coordinate, in [rad] or [m]."""
        path = path_of(table, muscle, self._displacements(q))
        return MuscleMotion(
            path,
            path.length - path_of(table, muscle).length,
            self._arm(table, muscle, q),
            self._over_range(table, muscle),
        )

    def _over_range(self, table: MuscleTable, muscle: str) -> tuple[float, ...]:
        """Return the moment arms over the range, computed once for each table."""
        if self._table is not table:
            self._table = table
            self._arms.clear()
        if muscle not in self._arms:
            low, high = self.range()
            samples = (low + (high - low) * k / (SAMPLES - 1) for k in range(SAMPLES))
            self._arms[muscle] = tuple(self._arm(table, muscle, x) for x in samples)
        return self._arms[muscle]

    def _arm(self, table: MuscleTable, muscle: str, q: float) -> float:
        before, after = (
            path_of(table, muscle, self._displacements(x)).length for x in (q - _STEP, q + _STEP)
        )
        return (before - after) / (2.0 * _STEP)

    def _displacements(self, q: float) -> Mapping[str, Transform]:
        """Return the displacement of each link from the pose of the design, in the root frame."""
        if q not in self._moved:
            at = {c.name: c.initial for c in self.robot.coordinates}
            before = link_poses(self.robot, at)
            after = link_poses(self.robot, at | {self.coordinate.name: q})
            self._moved[q] = {
                link: Transform.of(T).compose(Transform.of(before[link]).inverse())
                for link, T in after.items()
                if before[link] != T
            }
        return self._moved[q]


def arm_color(arm: float, largest: float) -> str:
    """Return the colour of a moment arm: red if positive, blue if negative, grey near zero.

    Args:
        largest: Largest absolute value of all moment arms, which has the full colour.
    """
    share = min(abs(arm) / largest, 1.0) if largest > 0.0 else 0.0
    full = _POSITIVE if arm > 0.0 else _NEGATIVE
    mixed = (round(z + share * (f - z)) for z, f in zip(_ZERO, full, strict=True))
    return "#{:02x}{:02x}{:02x}".format(*mixed)
