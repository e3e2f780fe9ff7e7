"""A link on one hinge, with muscles and wrap surfaces, for tests of writers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Literal

from addin_sdfusion.robot import (
    WORLD,
    CableSet,
    Coordinate,
    Inertia,
    Joint,
    Link,
    Motion,
    Muscle,
    Pose,
    Robot,
    ViaPoint,
    Wrap,
    WrapSurface,
    revolute,
)

SOLID = Inertia(1.0, (0.1, 0.2, 0.3), 1.0, 1.0, 1.0)
CASPR_ROBOTS = (
    *("BMArm", "Example_planar_XY", "Example_spatial", "Example_spherical"),
    *("Example_2R_planar_XZ", "RoboyLeftArm"),
)
"""Published robots that every writer supports."""


def one_link(
    inertia: Inertia = SOLID,
    muscles: Iterable[Muscle] = (),
    surfaces: Iterable[WrapSurface] = (),
    motions: tuple[Motion, ...] = revolute((0.0, 0.0, 1.0)),
    **coordinate: Any,
) -> Robot:
    """Return link `a` on joint `j` with coordinate `q` and given properties of `q`."""
    unit = motions[0].unit if motions else "rad"
    joint = Joint("j", WORLD, "a", motions, (Coordinate("q", unit=unit, **coordinate),))
    sets = (CableSet("all", tuple(muscles)),)
    return Robot("r", (Link("a", inertia),), (joint,), sets, "all", wrap_surfaces=tuple(surfaces))


def cable(start: Any, end: Any, **more: Any) -> Muscle:
    """Return a muscle `m` from the world to link `a`."""
    return Muscle("m", (ViaPoint(WORLD, start), ViaPoint("a", end)), **more)


def round_a_circle(
    shape: Literal["sphere", "cylinder"], side: Literal[-1, 0, 1]
) -> tuple[Robot, float]:
    """Return a muscle around a circle of radius 0.5, from (-1, 0.1) to (1, 0.1), and its length."""
    pose = Pose((0.0, 0.0, 0.2), (0.0, 0.0, 1.0))
    surface = WrapSurface("round", WORLD, shape, 0.5, pose)
    muscle = cable((-1.0, 0.1, 0.2), (1.0, 0.1, 0.2), wraps=(Wrap("round", 0, side),))
    radius = math.hypot(1.0, 0.1)
    reach, tangent = math.acos(0.5 / radius), math.sqrt(radius**2 - 0.25)
    above = math.pi - 2 * math.atan2(0.1, 1.0)  # the angle between the ends seen from the origin
    angle = 2 * math.pi - above if side == 1 else above
    length = 2 * tangent + 0.5 * (angle - 2 * reach)
    return one_link(muscles=[muscle], surfaces=[surface]), length
