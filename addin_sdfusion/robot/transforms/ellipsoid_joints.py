"""OpenSim joints on an ellipsoid, expressed exactly by rotations and constant translations.

The angles a, b, c rotate about the axes u, v, w. The position of the joint is the point at which
the rotated w is the normal of the ellipsoid with half axes A, B, C along u, v, w:

    p = A sin(b) u - B sin(a) cos(b) v + C cos(a) cos(b) w.

Each term is a sum of arms that are rotated by integer multiples of the angles, such as
A sin(b) u = R_w(-b) (A/2) v - R_w(b) (A/2) v. Therefore the result is exact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from ..model.function import constant, linear
from ..model.joint import Motion
from ..model.pose import Vector3, X, Y, Z
from ..model.rotations import cross

BACK: Vector3 = (-1.0, 0.0, 0.0)
A_, B_, C_, WINGING = range(4)
"""Indices of the coordinates: three angles, and the winging of a scapula off its ellipsoid."""

Arm = tuple[int, int, float]
"""Multiples of a and b by which the arm is rotated, and its length in [m]."""


class OverEllipsoid(NamedTuple):
    """An OpenSim joint on an ellipsoid.

    Attributes:
        radii: Half axes along x, y and z of the joint frame on the parent, in [m].
        winging: Winging axis of a ScapulothoracicJoint, which rotates by abduction, elevation and
            upward rotation: x and y of a point on the axis in the tangent plane of the ellipsoid,
            in [m], and the angle of the axis from y. None for an EllipsoidJoint.
    """

    radii: Vector3
    winging: Vector3 | None = None

    def motions(self) -> tuple[Motion, ...]:
        """Return the sequence of motions of the joint."""
        x, y, z = self.radii
        if self.winging is None:
            return _gliding((X, Y), self.radii)
        ox, oy, direction = self.winging
        axis = (-math.sin(direction), math.cos(direction), 0.0)
        return (
            *_gliding((Y, BACK), (y, x, z)),
            *_shift((ox, oy)),
            Motion("rotation", axis, WINGING),
            *_shift((-ox, -oy)),
        )


def over_ellipsoid(motions: Sequence[Motion]) -> OverEllipsoid | None:
    """Return the ellipsoid joint with these motions, or None."""
    moved = [k for k, motion in enumerate(motions) if not motion.is_fixed]
    winged = [k for k in moved if motions[k].coordinate == WINGING]
    turned = [k for k in moved if motions[k].coordinate == C_]
    if not turned or len(winged) > 1:
        return None
    winging: Vector3 | None = None
    if winged:
        axis, between = motions[winged[0]].axis, motions[turned[-1] + 1 : winged[0]]
        winging = (
            _shift_along(between, X),
            _shift_along(between, Y),
            math.atan2(-axis[0], axis[1]),
        )
    shifts = [m for m in motions[: turned[-1]] if m.kind == "translation"]
    along = [m.displacement(0.0) for m in shifts if m.axis == Z]
    A = 2.0 * next((m.displacement(0.0) for m in shifts if m.axis != Z), 0.0)
    if len(along) == 1:
        half_axes = (along[0],) * 3
    elif len(along) in (2, 4):
        other = along[1] if len(along) == 4 else 0.0
        half_axes = (A, 2.0 * (along[0] - other), 2.0 * (along[0] + other))
    else:
        return None
    a, b, c = half_axes
    exact = (a, b, c) if winging is None else (b, a, c)
    short = (_rounded(exact[0]), _rounded(exact[1]), _rounded(exact[2]))
    candidates = [OverEllipsoid(radii, winging) for radii in (short, exact)]
    return next((joint for joint in candidates if joint.motions() == tuple(motions)), None)


def _shift_along(motions: Sequence[Motion], axis: Vector3) -> float:
    return sum(motion.displacement(0.0) for motion in motions if motion.axis == axis)


def _rounded(value: float) -> float:
    """Return a number without the rounding errors of sums and halves of file values."""
    return float(f"{value:.14g}")


def _gliding(axes: tuple[Vector3, Vector3], radii: Vector3) -> tuple[Motion, ...]:
    """Return the motions of a body that slides on an ellipsoid and rotates about its normal.

    Args:
        axes: u and v.
        radii: A, B and C, in [m].
    """
    u, v = axes
    w = cross(u, v)
    A, B, C = radii
    turned = (Motion("rotation", v, B_), Motion("rotation", w, C_))
    if A == B == C:
        arm = Motion("translation", w, 0, constant(C))
        return (Motion("rotation", u, A_), turned[0], arm, turned[1])
    mean, difference = 0.25 * (C + B), 0.25 * (C - B)
    across: Sequence[Arm] = ((0, -1, 0.5 * A), (0, 1, -0.5 * A), (0, 0, 0.0))
    along: Sequence[Arm] = (
        (1, 1, mean),
        (-1, -1, difference),
        (1, -1, mean),
        (-1, 1, difference),
        (1, 0, 0.0),
    )
    return (*_arms(w, v, across), *_arms(u, w, along), *turned)


def _arms(axis: Vector3, direction: Vector3, arms: Sequence[Arm]) -> list[Motion]:
    """Return arms along a direction, each rotated about an axis; the last sets the end rotation."""
    motions: list[Motion] = []
    a = b = 0
    for k, (next_a, next_b, length) in enumerate(arms):
        if length == 0.0 and k < len(arms) - 1:
            continue
        for coordinate, by in ((A_, next_a - a), (B_, next_b - b)):
            if by:
                motions.append(Motion("rotation", axis, coordinate, linear(float(by))))
        if length:
            motions.append(Motion("translation", direction, 0, constant(length)))
        a, b = next_a, next_b
    return motions


def _shift(by: tuple[float, float]) -> list[Motion]:
    shifts = zip((X, Y), by, strict=True)
    return [Motion("translation", axis, 0, constant(shift)) for axis, shift in shifts if shift]
