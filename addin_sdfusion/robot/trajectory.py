"""A joint trajectory as robot files hold it: points to interpolate, no interpolation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Spline = Literal["linear", "cubic", "quintic"]


@dataclass(frozen=True, slots=True)
class TrajectoryPoint:
    """A point to pass through.

    Attributes:
        time: Absolute, in [s].
        q: Joint positions, in [rad] or [m].
        qd: Joint velocities; empty for a linear spline.
        qdd: Joint accelerations; empty unless the spline is quintic.
    """

    time: float
    q: tuple[float, ...]
    qd: tuple[float, ...] = ()
    qdd: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Trajectory:
    """A named joint trajectory.

    Attributes:
        name: Its name.
        spline: How to interpolate: `linear`, `cubic` (Hermite) or `quintic`.
        points: At least two, at increasing times; the first at 0 s.
        time_step: Sample time that the file asks for, in [s].
    """

    name: str
    spline: Spline
    points: tuple[TrajectoryPoint, ...]
    time_step: float
