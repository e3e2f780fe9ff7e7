"""Robots of known shape for tests."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import (
    IDENTITY,
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
    read_robot,
    revolute,
)

EXAMPLES = Path(__file__).parents[3] / "examples"
PLANAR_2R = EXAMPLES / "planar_2r"
HELD = {
    f"robot.joints.joint_{k}.coordinates[0].{key}": value
    for k, rest in ((1, -0.5), (2, 0.5))
    for key, value in (("stiffness", 50.0), ("rest", rest), ("damping", 5.0))
}
"""Settings for springs that hold `PLANAR_2R` near its start if commands are late."""


def planar_2r(cable_set: str | None = None) -> Robot:
    """Return the two-link arm of the paper, from the files of the example."""
    return read_robot(PLANAR_2R / "robot", cable_set)


def with_coordinates(robot: Robot, **changes: Any) -> Robot:
    """Return the robot with changes to all of its coordinates."""
    joints = tuple(
        replace(joint, coordinates=tuple(replace(c, **changes) for c in joint.coordinates))
        for joint in robot.joints
    )
    return replace(robot, joints=joints)


def one_joint(
    name: str,
    motions: tuple[Motion, ...],
    inertia: Inertia,
    pose: Pose = IDENTITY,
    **coordinate: Any,
) -> Robot:
    """Return a robot with one link on one joint, all with the same name."""
    joint = Joint(name, WORLD, name, motions, (Coordinate(name, **coordinate),), pose)
    return Robot(name, (Link(name, inertia),), (joint,))


def stopped(robot: Robot, upper: float) -> Robot:
    """Return a robot with an upper limit of its first coordinate."""
    first, *others = robot.joints
    (stop,) = first.coordinates
    return replace(
        robot, joints=(replace(first, coordinates=(replace(stop, upper=upper),)), *others)
    )


def chain(joints: int = 20, muscles: int = 60, points: int = 4) -> Robot:
    """Return a hanging chain of revolute joints about alternating axes; muscles span four links."""
    rng = np.random.default_rng(7)
    links = tuple(
        Link(f"link_{k}", Inertia(0.5, (0.0, 0.0, -0.05), 1e-3, 1e-3, 5e-4)) for k in range(joints)
    )
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    tree = tuple(
        Joint(
            f"joint_{k}",
            WORLD if k == 0 else f"link_{k - 1}",
            f"link_{k}",
            revolute(axes[k % 2]),
            (Coordinate(f"joint_{k}", damping=0.05),),
            Pose((0.0, 0.0, 0.0 if k == 0 else -0.1)),
        )
        for k in range(joints)
    )
    cables = []
    for k in range(muscles):
        first = int(rng.integers(-1, joints - points + 1))
        angle = 2 * math.pi * k / muscles
        offset = (0.03 * math.cos(angle), 0.03 * math.sin(angle))
        over = [WORLD if b < 0 else f"link_{b}" for b in range(first, first + points)]
        cables.append(
            Muscle(f"muscle_{k}", tuple(ViaPoint(b, (*offset, -0.05)) for b in over), 1.0, 100.0)
        )
    return Robot("chain", links, tree, (CableSet("all", tuple(cables)),), "all")
