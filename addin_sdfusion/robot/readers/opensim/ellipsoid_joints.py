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

from ...model.function import constant, linear
from ...model.joint import Motion
from ...model.pose import Vector3
from ...model.rotations import cross
from ..xml import Node

X: Vector3 = (1.0, 0.0, 0.0)
Y: Vector3 = (0.0, 1.0, 0.0)
Z: Vector3 = (0.0, 0.0, 1.0)
A_, B_, C_, WINGING = range(4)
"""The coordinates: three angles; and of a scapula one that lifts it off its ellipsoid."""

Arm = tuple[int, int, float]
"""How often a and b it is turned by, and its length in [m]."""


def ellipsoid_joint(node: Node) -> tuple[Motion, ...]:
    """The motions of an EllipsoidJoint."""
    return gliding((X, Y), node.vector("radii_x_y_z"))


def scapulothoracic_joint(node: Node) -> tuple[Motion, ...]:
    """The motions of a ScapulothoracicJoint: abduction, elevation, upward rotation, winging.

    The scapula glides over the thorax; its winging turns it about an axis in the plane that touches
    the ellipsoid, through a point of that plane.
    """
    x, y, z = node.vector("thoracic_ellipsoid_radii_x_y_z")
    given = node.optional("scapula_winging_axis_origin")
    ox, oy = (0.0, 0.0) if given is None else given.numbers(2)
    direction = node.number("scapula_winging_axis_direction", 0.0)
    axis = (-math.sin(direction), math.cos(direction), 0.0)
    there = _shift((ox, oy))
    return (
        *gliding((Y, (-1.0, 0.0, 0.0)), (y, x, z)),
        *there,
        Motion("rotation", axis, WINGING),
        *_shift((-ox, -oy)),
    )


def gliding(axes: tuple[Vector3, Vector3], radii: Vector3) -> tuple[Motion, ...]:
    """The motions of a body that glides over an ellipsoid and turns about its normal.

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
