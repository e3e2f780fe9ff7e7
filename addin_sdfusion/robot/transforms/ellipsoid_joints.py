"""Joints of OpenSim that glide over an ellipsoid, as turns and constant arms one after another.

Angles a, b, c turn about axes u, v, w; the joint's place is where w, turned so, is the normal of
the ellipsoid with half axes A, B, C along them:

    p = A sin(b) u - B sin(a) cos(b) v + C cos(a) cos(b) w.

Each term is a sum of arms that turn by whole multiples of the angles, such as
A sin(b) u = R_w(-b) (A/2) v - R_w(b) (A/2) v, so that nothing is approximated.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from ..model.function import constant, linear
from ..model.joint import Motion
from ..model.pose import Vector3
from ..model.rotations import cross

X: Vector3 = (1.0, 0.0, 0.0)
Y: Vector3 = (0.0, 1.0, 0.0)
Z: Vector3 = (0.0, 0.0, 1.0)
BACK: Vector3 = (-1.0, 0.0, 0.0)
A_, B_, C_, WINGING = range(4)
"""The coordinates: three angles; and of a scapula one that lifts it off its ellipsoid."""

Arm = tuple[int, int, float]
"""How often a and b it is turned by, and its length in [m]."""


class OverEllipsoid(NamedTuple):
    """A joint of OpenSim over an ellipsoid.

    Attributes:
        radii: The half axes along x, y and z of the joint's frame on the parent, in [m].
        winging: Of a ScapulothoracicJoint, which turns by abduction, elevation and upward rotation:
            the point in the plane that touches the ellipsoid through which the axis of winging
            goes, in [m], and the axis's angle from y there. None for an EllipsoidJoint.
    """

    radii: Vector3
    winging: Vector3 | None = None

    def motions(self) -> tuple[Motion, ...]:
        """Its motions one after another."""
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
    """Return the joint over an ellipsoid that has these motions, or None."""
    moved = [k for k, motion in enumerate(motions) if not motion.is_fixed]
    winged = [k for k in moved if motions[k].coordinate == WINGING]
    turned = [k for k in moved if motions[k].coordinate == C_]
    if not turned or len(winged) > 1:
        return None
    winging: Vector3 | None = None
    if winged:
        axis, between = motions[winged[0]].axis, motions[turned[-1] + 1 : winged[0]]
        winging = (_way(between, X), _way(between, Y), math.atan2(-axis[0], axis[1]))
    ways = [m for m in motions[: turned[-1]] if m.kind == "translation"]
    along = [m.way(0.0) for m in ways if m.axis == Z]
    A = 2.0 * next((m.way(0.0) for m in ways if m.axis != Z), 0.0)
    if len(along) == 1:
        half_axes = (along[0],) * 3
    elif len(along) in (2, 4):
        other = along[1] if len(along) == 4 else 0.0
        half_axes = (A, 2.0 * (along[0] - other), 2.0 * (along[0] + other))
    else:
        return None
    a, b, c = half_axes
    exact = (a, b, c) if winging is None else (b, a, c)
    short = (_shortened(exact[0]), _shortened(exact[1]), _shortened(exact[2]))
    found = [OverEllipsoid(radii, winging) for radii in (short, exact)]
    return next((joint for joint in found if joint.motions() == tuple(motions)), None)


def _way(motions: Sequence[Motion], axis: Vector3) -> float:
    return sum(motion.way(0.0) for motion in motions if motion.axis == axis)


def _shortened(value: float) -> float:
    """Return a number as it was written before it was halved and added to others."""
    return float(f"{value:.14g}")


def _gliding(axes: tuple[Vector3, Vector3], radii: Vector3) -> tuple[Motion, ...]:
    """Return the motions of a body that glides over an ellipsoid and turns about its normal.

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
    """Arms along a direction, each turned about an axis; the last one says how it is left."""
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
    ways = zip((X, Y), by, strict=True)
    return [Motion("translation", axis, 0, constant(way)) for axis, way in ways if way]
