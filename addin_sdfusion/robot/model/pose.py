"""Points and poses, represented as in robot files."""

from __future__ import annotations

from dataclasses import dataclass

Vector3 = tuple[float, float, float]

X: Vector3 = (1.0, 0.0, 0.0)
Y: Vector3 = (0.0, 1.0, 0.0)
Z: Vector3 = (0.0, 0.0, 1.0)
AXES = (X, Y, Z)
"""Axes of a frame, expressed in it."""


@dataclass(frozen=True, slots=True)
class Pose:
    """A rigid transform: rotate by roll, pitch, yaw about the fixed axes, then translate.

    Attributes:
        position: Translation, in [m].
        rpy: Roll about x, pitch about y, yaw about z, in [rad]: R = Rz(yaw) Ry(pitch) Rx(roll).
    """

    position: Vector3 = (0.0, 0.0, 0.0)
    rpy: Vector3 = (0.0, 0.0, 0.0)


IDENTITY = Pose()
