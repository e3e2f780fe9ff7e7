"""Trajectories in robot files: the points to interpolate, without the interpolation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Spline = Literal["linear", "cubic", "quintic", "parabolic_blend", "samples"]
Space = Literal["joint", "operational"]


@dataclass(frozen=True, slots=True)
class TrajectoryPoint:
    """A point of a trajectory.

    In an operational trajectory q, qd and qdd contain y and its derivatives, in the order of the
    axes of the operational space.

    Attributes:
        time: Absolute time, in [s].
        q: Positions, in [rad] or [m].
        qd: Velocities; empty for a linear spline and a parabolic blend.
        qdd: Accelerations; empty unless the spline is quintic or consists of samples.
        blend_time: Duration of the acceleration and of the deceleration in the segment that ends at
            this point of a parabolic blend, in [s]; otherwise 0.
    """

    time: float
    q: tuple[float, ...]
    qd: tuple[float, ...] = ()
    qdd: tuple[float, ...] = ()
    blend_time: float = 0.0


@dataclass(frozen=True, slots=True)
class Trajectory:
    """A named trajectory. Every coordinate is interpolated independently.

    CASPR interpolates the angles of spherical and spatial joints with quaternions. Its path between
    two orientations is therefore different, but has the same points.

    Attributes:
        name: Name of the trajectory.
        spline: Interpolation: `linear`, `cubic` (Hermite), `quintic`, `parabolic_blend` (at rest in
            every point, with parabolas at both ends of a linear segment), or `samples` (dense
            points at multiples of the time step).
        points: At least two points with increasing times, the first at 0 s.
        time_step: Sample time that the file specifies, in [s].
        space: Whether q contains joint positions or the y of an operational space.
    """

    name: str
    spline: Spline
    points: tuple[TrajectoryPoint, ...]
    time_step: float
    space: Space = "joint"
