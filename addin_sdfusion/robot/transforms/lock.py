"""Locking of coordinates: their motions become constant parts of the joint poses.

The locked robot has exactly the dynamics of the original robot with constant coordinates: M, C, G,
l, L, y and J are the rows and columns of the remaining coordinates.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..errors import InputError
from ..finding_builders import all_muscles
from ..model.joint import Coordinate, Joint, Motion
from ..model.robot import Robot, find
from ..model.rotations import normalized, rotate
from ..model.transform import IDENTITY, Transform, motion_transform


def lock(robot: Robot, positions: Mapping[str, float]) -> Robot:
    """Return the robot without some coordinates.

    A joint without remaining coordinates becomes a fixed joint. If the robot has functions or
    couplings, or if muscles depend directly on a locked coordinate, the coordinates remain in their
    joints and are marked as locked.

    Args:
        positions: Values of the locked coordinates by name, in [rad] or [m].

    Raises:
        UnknownNameError: A coordinate does not exist.
        InputError: A translation between two rotations of one joint is locked at a value other than
            0, which a joint cannot express.
    """

    def mark_locked(c: Coordinate) -> Coordinate:
        marked = c.name in positions
        return replace(c, locked=True, initial=positions[c.name], actuated=False) if marked else c

    for name in positions:
        find("coordinate", name, robot.coordinates)
    named: set[str] = set()
    for _, muscle in all_muscles(robot):
        named |= {point.when.coordinate for point in muscle.via_points if point.when is not None}
        named |= {move.coordinate for point in muscle.via_points for move in point.moves}
        named |= {term.coordinate for term in muscle.terms}
    if robot.driven_joints or named & set(positions):
        # coupled coordinates must follow the locked ones
        joints = tuple(joint.map_coordinates(mark_locked) for joint in robot.joints)
        return replace(robot, joints=joints)
    joints = tuple(_remove_locked(joint, positions) for joint in robot.joints)
    return replace(robot, joints=joints)


def _remove_locked(joint: Joint, positions: Mapping[str, float]) -> Joint:
    remaining = tuple(c for c in joint.coordinates if c.name not in positions)
    if remaining == joint.coordinates:
        return joint
    before, R, p = Transform.of(joint.T_parent_joint), IDENTITY.R, IDENTITY.p
    motions: list[Motion] = []
    for motion in joint.motions:  # R and p are the locked transform since the last free motion
        coordinate = joint.coordinates[motion.coordinate]
        if coordinate.name in positions:
            T = motion_transform(motion.kind, motion.axis, positions[coordinate.name])
            R, p = Transform(R, p).compose(T)
            continue
        if all(m.kind == "translation" for m in motions):  # translations commute
            before, p = before.compose(Transform(IDENTITY.R, p)), IDENTITY.p
        if motion.kind == "rotation" and any(p):
            raise _between_rotations(joint, positions)
        axis = normalized(rotate(R, motion.axis))
        motions.append(replace(motion, axis=axis, coordinate=remaining.index(coordinate)))
    T_child_next = Transform.of(joint.T_child_joint).compose(Transform(R, p).inverse())
    return replace(
        joint,
        motions=tuple(motions),
        coordinates=remaining,
        T_parent_joint=before.pose(),
        T_child_joint=T_child_next.pose(),
    )


def _between_rotations(joint: Joint, positions: Mapping[str, float]) -> InputError:
    coordinates = [joint.coordinates[motion.coordinate] for motion in joint.motions]
    name = next(c.name for c in coordinates if c.unit == "m" and positions.get(c.name))
    problem = "a translation between two rotations of a joint can only be locked at 0"
    return InputError(problem, key=f"coordinates.{name}.locked")
