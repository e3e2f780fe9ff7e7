"""Trajectories as robot files hold them: points to interpolate, no interpolation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Spline = Literal["linear", "cubic", "quintic", "parabolic_blend", "samples"]
Space = Literal["joint", "operational"]


@dataclass(frozen=True, slots=True)
class TrajectoryPoint:
    """A point to pass through.

    Of an operational trajectory q, qd and qdd hold y and its derivatives, in the order of the axes
    of an operational space.

    Attributes:
        time: Absolute, in [s].
        q: Positions, in [rad] or [m].
        qd: Velocities; empty for a linear spline and a parabolic blend.
        qdd: Accelerations; empty unless the spline is quintic or holds samples.
        blend_time: Of a parabolic blend, how long the segment from the point before speeds up, and
            how long it slows down, in [s]; else 0.
    """

    time: float
    q: tuple[float, ...]
    qd: tuple[float, ...] = ()
    qdd: tuple[float, ...] = ()
    blend_time: float = 0.0


@dataclass(frozen=True, slots=True)
class Trajectory:
    """A named trajectory. Every coordinate is interpolated for itself.

    CASPR interpolates the angles of spherical and spatial joints through quaternions instead; its
    way between two orientations is another one, through the same points.

    Attributes:
        name: Its name.
        spline: How to interpolate: `linear`, `cubic` (Hermite), `quintic`, `parabolic_blend` (at
            rest in every point, parabolas at both ends of a straight middle), or `samples`, dense
            points at multiples of the time step.
        points: At least two, at increasing times; the first at 0 s.
        time_step: Sample time that the file asks for, in [s].
        space: Whether q is joint positions or an operational space's y.
    """

    name: str
    spline: Spline
    points: tuple[TrajectoryPoint, ...]
    time_step: float
    space: Space = "joint"
