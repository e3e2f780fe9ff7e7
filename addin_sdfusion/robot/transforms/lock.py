"""Robots with some coordinates held at a value: their motions become part of the joints' poses.

What is left moves exactly as the robot with these coordinates held does: M, C, G, l, L, y and J are
the rows and columns of the others.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..errors import InputError
from ..finding_builders import all_muscles
from ..model.joint import Joint, Motion
from ..model.pose import Pose
from ..model.robot import Robot, find
from ..model.rotations import axis_rotation, normalized, rotate, rotation
from ..model.transform import IDENTITY, Transform


def lock(robot: Robot, positions: Mapping[str, float]) -> Robot:
    """Return the robot without some coordinates; a joint that keeps none becomes a fixed one.

    In a robot with functions or couplings, or with muscles that depend on them beside their bodies,
    they stay in its joints, and are locked there.

    Args:
        robot: The robot.
        positions: What they are held at, in [rad] or [m], by the coordinates' names.

    Raises:
        UnknownNameError: There is no such coordinate.
        InputError: A translation between two rotations of one joint would be held elsewhere than at
            0, which no joint can express.
    """
    for name in positions:
        find("coordinate", name, robot.coordinates)
    named: set[str] = set()
    for _, muscle in all_muscles(robot):
        named |= {point.when.coordinate for point in muscle.via_points if point.when is not None}
        named |= {move.coordinate for point in muscle.via_points for move in point.moves}
        named |= {term.coordinate for term in muscle.terms}
    if robot.driven_joints or named & set(positions):
        # what follows a coordinate is to follow it if it is held
        return replace(robot, joints=tuple(_held(joint, positions) for joint in robot.joints))
    return replace(robot, joints=tuple(_locked(joint, positions) for joint in robot.joints))


def _held(joint: Joint, positions: Mapping[str, float]) -> Joint:
    coordinates = (
        replace(c, locked=True, initial=positions[c.name], actuated=False)
        if c.name in positions
        else c
        for c in joint.coordinates
    )
    return replace(joint, coordinates=tuple(coordinates))


def _locked(joint: Joint, positions: Mapping[str, float]) -> Joint:
    left = tuple(c for c in joint.coordinates if c.name not in positions)
    if left == joint.coordinates:
        return joint
    before, R, p = _transform(joint.T_parent_joint), IDENTITY.R, IDENTITY.p
    motions: list[Motion] = []
    for motion in joint.motions:  # R and p are what is held since the last motion that is left
        own = joint.coordinates[motion.coordinate]
        if own.name in positions:
            R, p = Transform(R, p).compose(_moved(motion, positions[own.name]))
            continue
        if all(m.kind == "translation" for m in motions):  # they commute with a translation
            before, p = before.compose(Transform(IDENTITY.R, p)), IDENTITY.p
        if motion.kind == "rotation" and any(p):
            raise _between_rotations(joint, positions)
        axis = normalized(rotate(R, motion.axis))
        motions.append(replace(motion, axis=axis, coordinate=left.index(own)))
    T_child_next = _transform(joint.T_child_joint).compose(Transform(R, p).inverse())
    return replace(
        joint,
        motions=tuple(motions),
        coordinates=left,
        T_parent_joint=before.pose(),
        T_child_joint=T_child_next.pose(),
    )


def _between_rotations(joint: Joint, positions: Mapping[str, float]) -> InputError:
    held = [joint.coordinates[motion.coordinate] for motion in joint.motions]
    name = next(c.name for c in held if c.unit == "m" and positions.get(c.name))
    what = "a translation between two rotations of a joint can only be locked at 0"
    return InputError(what, key=f"coordinates.{name}.locked")


def _transform(pose: Pose) -> Transform:
    return Transform(rotation(pose.rpy), pose.position)


def _moved(motion: Motion, value: float) -> Transform:
    """Return the transform of a motion."""
    if motion.kind == "rotation":
        return Transform(axis_rotation(motion.axis, value), (0.0, 0.0, 0.0))
    x, y, z = motion.axis
    return Transform(IDENTITY.R, (value * x, value * y, value * z))
