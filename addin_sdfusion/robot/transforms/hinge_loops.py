"""Revolute loop joints as two coincident points on their axis, for formats without hinges."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from ..model.loop import LoopJoint
from ..model.pose import IDENTITY, Pose, Vector3
from ..model.robot import Robot
from ..model.rotations import (
    axis_rotation,
    compose,
    cross,
    dot,
    normalized,
    rpy,
    subtract,
)
from .joint_chains import Names

ARM = 0.1
"""Distance of the two points, in [m]."""
_EQUAL = 1e-9
_SAME_AXIS = 1e-14


def with_hinges_as_points(robot: Robot) -> Robot:
    """Return the robot with two ball loop joints instead of each revolute loop joint.

    The first one has the name of the loop joint.
    """
    names = Names([*(joint.name for joint in robot.joints), *(loop.name for loop in robot.loops)])
    loops: list[LoopJoint] = []
    for loop in robot.loops:
        if loop.type != "revolute":
            loops.append(loop)
            continue
        x, y, z = loop.axes[0]
        along = Pose((ARM * x, ARM * y, ARM * z))
        ends = loop.T_parent_joint, loop.T_child_joint
        for name, shift in ((loop.name, IDENTITY), (names.unique(f"{loop.name}_axis"), along)):
            parent, child = (Pose(compose(T, shift).position) for T in ends)
            loops.append(LoopJoint(name, loop.parent, loop.child, "ball", (), parent, child))
    return replace(robot, loops=tuple(loops))


def merge_points_to_hinges(loops: Iterable[LoopJoint]) -> tuple[LoopJoint, ...]:
    """Return the loop joints with pairs of coincident points merged to revolute loop joints.

    Two consecutive points between the same links form a hinge if their distance is equal in both
    links. The hinge has the name of the first one.
    """
    made: list[LoopJoint] = []
    for loop in loops:
        hinge = _hinge(made[-1], loop) if made else None
        if hinge is None:
            made.append(loop)
        else:
            made[-1] = hinge
    return tuple(made)


def _hinge(first: LoopJoint, second: LoopJoint) -> LoopJoint | None:
    """Return the hinge through two points, or None."""
    ends = [(loop.type, loop.parent, loop.child) for loop in (first, second)]
    if first.type != "ball" or ends[0] != ends[1]:
        return None
    in_parent = subtract(second.T_parent_joint.position, first.T_parent_joint.position)
    in_child = subtract(second.T_child_joint.position, first.T_child_joint.position)
    length = math.hypot(*in_parent)
    if length == 0.0 or abs(math.hypot(*in_child) - length) > _EQUAL * length:
        return None
    axis = normalized(in_parent)
    return replace(
        first,
        type="revolute",
        axes=(axis,),
        T_parent_joint=Pose(first.T_parent_joint.position),
        T_child_joint=Pose(first.T_child_joint.position, _rotation(axis, normalized(in_child))),
    )


def _rotation(a: Vector3, b: Vector3) -> Vector3:
    """Return roll, pitch, yaw of the smallest rotation of a unit vector to another one."""
    across = cross(a, b)
    sine = math.hypot(*across)
    if sine <= _SAME_AXIS and dot(a, b) > 0.0:
        return IDENTITY.rpy
    if sine <= _SAME_AXIS:
        least = min((abs(x), k) for k, x in enumerate(a))[1]
        across = cross(a, (float(least == 0), float(least == 1), float(least == 2)))
    return rpy(axis_rotation(normalized(across), math.atan2(sine, dot(a, b))))
