"""Chains of single-motion joints, through massless links, for joints of several motions.

What the formats with one motion a joint share: a joint of n motions becomes n joints, in the order
of its motions, and the n - 1 links between them are called `<joint>_1`, `<joint>_2`, ... A single
joint that moves has the name of its coordinate, a fixed one its own. Where a name is taken already,
underscores are put at its end.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from ..model.joint import Coordinate, Joint, Motion
from ..model.pose import IDENTITY, Pose
from ..model.robot import WORLD, Robot


class Names:
    """Unique names: those that are taken get underscores at their end."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = set(taken)

    def give(self, name: str) -> str:
        """That name, or the nearest that is free."""
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return name


@dataclass(frozen=True, slots=True)
class SingleJoint:
    """A joint with one motion, or a fixed one.

    Attributes:
        name: Unique among the single joints.
        parent, child: Links of the robot, `WORLD`, or links without mass between single joints.
        T_parent_joint: Pose of the joint frame in the parent's frame.
        T_child_joint: Pose of the frame after the motion in the child's frame.
        motion: None for a fixed joint.
        coordinate: What drives the motion; None for a fixed joint.
    """

    name: str
    parent: str
    child: str
    T_parent_joint: Pose
    T_child_joint: Pose
    motion: Motion | None = None
    coordinate: Coordinate | None = None


def single_joints(robot: Robot) -> list[SingleJoint]:
    """The joints of a robot as single ones, parents first."""
    links = Names([WORLD, *(link.name for link in robot.links)])
    joints = Names(coordinate.name for coordinate in robot.all_coordinates)
    return [single for joint in robot.joints for single in _split(joint, links, joints)]


def _split(joint: Joint, links: Names, joints: Names) -> Iterator[SingleJoint]:
    parent, T_parent_joint = joint.parent, joint.T_parent_joint
    if not joint.motions:
        name = joints.give(joint.name)
        yield SingleJoint(name, parent, joint.child, T_parent_joint, joint.T_child_joint)
    for k, motion in enumerate(joint.motions, start=1):
        last = k == len(joint.motions)
        child = joint.child if last else links.give(f"{joint.name}_{k}")
        T_child_joint = joint.T_child_joint if last else IDENTITY
        coordinate = joint.coordinates[motion.coordinate]
        yield SingleJoint(
            coordinate.name, parent, child, T_parent_joint, T_child_joint, motion, coordinate
        )
        parent, T_parent_joint = child, IDENTITY
