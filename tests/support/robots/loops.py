"""Mechanisms with closed loops."""

from __future__ import annotations

import math
from dataclasses import replace

from addin_sdfusion.robot import (
    WORLD,
    CableSet,
    Coordinate,
    Inertia,
    Joint,
    Link,
    LoopJoint,
    Muscle,
    Pose,
    Robot,
    ViaPoint,
    prismatic,
    revolute,
)

Y = (0.0, 1.0, 0.0)


def bar(name: str, length: float) -> Link:
    """A rod along x from its frame's origin, with 1 kg a metre."""
    mass = length
    across = mass * length**2 / 12.0
    return Link(name, Inertia(mass, (0.5 * length, 0.0, 0.0), 1e-6, across, across))


def hinge(name: str, parent: str, child: str, x: float, initial: float = 0.0) -> Joint:
    """A hinge about y at a place along the parent's x axis."""
    coordinate = Coordinate(name, initial=initial)
    return Joint(name, parent, child, revolute(Y), (coordinate,), Pose((x, 0.0, 0.0)))


def four_bar(
    lengths: tuple[float, float, float, float] = (0.2, 0.5, 0.4, 0.5), crank: float = 1.0
) -> Robot:
    """A planar four-bar linkage of crank, coupler, rocker and ground, closed at the start.

    Angles are negative turns about y, so that positive ones lift the bars against gravity.

    Args:
        lengths: Of crank, coupler, rocker and ground, in [m].
        crank: Its angle at the start above the ground, in [rad].
    """
    a, b, c, d = lengths
    coupler, rocker = four_bar_angles(lengths, crank)
    joints = (
        hinge("crank", WORLD, "crank_bar", 0.0, -crank),
        hinge("coupler", "crank_bar", "coupler_bar", a, -(coupler - crank)),
        hinge("rocker", WORLD, "rocker_bar", d, -rocker),
    )
    links = (bar("crank_bar", a), bar("coupler_bar", b), bar("rocker_bar", c))
    loop = LoopJoint(
        "closing", "coupler_bar", "rocker_bar", "revolute", (Y,), Pose((b, 0, 0)), Pose((c, 0, 0))
    )
    muscles = tuple(
        Muscle(f"cable_{k}", (ViaPoint(WORLD, (x, 0.0, -0.3)), ViaPoint(link, (0.1, 0.0, 0.0))))
        for k, (x, link) in enumerate([(-0.1, "crank_bar"), (0.6, "rocker_bar")])
    )
    return Robot("four_bar", links, joints, (CableSet("all", muscles),), "all", loops=(loop,))


def four_bar_angles(
    lengths: tuple[float, float, float, float], crank: float
) -> tuple[float, float]:
    """Angles of coupler and rocker above the ground, in [rad]: the open branch."""
    a, b, c, d = lengths
    x, z = d - a * math.cos(crank), -a * math.sin(crank)
    r, towards = math.hypot(x, z), math.atan2(z, x)
    coupler = towards + math.acos((r * r + b * b - c * c) / (2.0 * r * b))
    rocker = math.atan2(
        a * math.sin(crank) + b * math.sin(coupler), a * math.cos(crank) + b * math.cos(coupler) - d
    )
    return coupler, rocker


def slider_crank(crank: float = 0.2, rod: float = 0.5, angle: float = 1.0) -> Robot:
    """A crank, a rod and a slider along x: the rod's end is pinned to the slider."""
    swing = math.asin(crank * math.sin(angle) / rod)
    place = crank * math.cos(angle) + rod * math.cos(swing)
    slide = Coordinate("slide", initial=place, unit="m")
    joints = (
        hinge("crank", WORLD, "crank_bar", 0.0, -angle),
        hinge("rod", "crank_bar", "rod_bar", crank, swing + angle),
        Joint("slide", WORLD, "slider", prismatic((1.0, 0.0, 0.0)), (slide,)),
    )
    block = Link("slider", Inertia(0.3, ixx=1e-4, iyy=1e-4, izz=1e-4))
    links = (bar("crank_bar", crank), bar("rod_bar", rod), block)
    loop = LoopJoint("pin", "rod_bar", "slider", "revolute", (Y,), Pose((rod, 0.0, 0.0)))
    return Robot("slider_crank", links, joints, loops=(loop,))


def with_loop(robot: Robot, **changes: object) -> Robot:
    """The robot with fields of its only loop joint changed."""
    return replace(robot, loops=(replace(robot.loops[0], **changes),))  # type: ignore[arg-type]
