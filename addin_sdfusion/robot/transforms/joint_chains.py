"""Chains of single-motion joints, through massless links, for joints of several motions.

What the formats with one motion a joint share: a joint of n motions becomes n joints, in the order
of its motions, and the n - 1 links between them are called `<joint>_1`, `<joint>_2`, ... A single
joint that moves has the name of its coordinate, a fixed one its own or, in a chain, `<joint>_<k>`.
Motions that count from another zero begin at another place. Where a name is taken already,
underscores are put at its end, or a number where many have it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from ..model.function import ITSELF, linear
from ..model.joint import Coordinate, Joint, Motion
from ..model.pose import IDENTITY, Pose
from ..model.robot import WORLD, Robot
from ..model.rotations import axis_rotation, compose
from ..model.transform import Transform

_MAX_UNDERSCORES = 8
"""Highest numeric suffix of a name."""


class Names:
    """Unique names: those that are taken get underscores at their end, then a number."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = set(taken)
        self._numbers: Counter[str] = Counter()

    def give(self, name: str) -> str:
        """That name, or the nearest that is free."""
        free = name
        for _ in range(_MAX_UNDERSCORES):
            if free in self._taken:
                free += "_"
        while free in self._taken:
            self._numbers[name] += 1
            free = f"{name}_{self._numbers[name]}"
        self._taken.add(free)
        return free


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

    def joint(self, name: str) -> Joint:
        """Return the same as a joint of a robot, under a name."""
        motions = () if self.motion is None else (replace(self.motion, coordinate=0),)
        coordinates = () if self.coordinate is None else (self.coordinate,)
        frames = self.T_parent_joint, self.T_child_joint
        return Joint(name, self.parent, self.child, motions, coordinates, *frames)


def single_joints(robot: Robot, *, whole: bool = False) -> list[SingleJoint]:
    """Return the joints of a robot as single ones, parents first.

    Args:
        robot: The robot.
        whole: Whether motions keep their functions, those that stand still as well. The motion that
            is a coordinate's own has its name then, and others `<joint>_<k>`.
    """
    links = Names([WORLD, *(link.name for link in robot.links)])
    joints = Names(coordinate.name for coordinate in robot.all_coordinates)
    return [single for joint in robot.joints for single in _split(joint, links, joints, whole)]


def _split(joint: Joint, links: Names, joints: Names, whole: bool) -> Iterator[SingleJoint]:
    parent, T_parent_joint = joint.parent, joint.T_parent_joint
    if not joint.motions:
        name = joints.give(joint.name)
        yield SingleJoint(name, parent, joint.child, T_parent_joint, joint.T_child_joint)
    for k, motion in enumerate(joint.motions, start=1):
        last = k == len(joint.motions)
        child = joint.child if last else links.give(f"{joint.name}_{k}")
        T_child_joint = joint.T_child_joint if last else IDENTITY
        T_joint_zero, moved = (IDENTITY, motion) if whole else _from_zero(motion)
        T_parent_joint = (
            T_parent_joint if T_joint_zero == IDENTITY else (compose(T_parent_joint, T_joint_zero))
        )
        if moved is None:
            name = joints.give(f"{joint.name}_{k}")
            yield SingleJoint(name, parent, child, T_parent_joint, T_child_joint)
        else:
            coordinate = joint.coordinates[motion.coordinate]
            is_other = whole and joint.home(motion.coordinate) != k - 1
            name = joints.give(f"{joint.name}_{k}") if is_other else coordinate.name
            yield SingleJoint(name, parent, child, T_parent_joint, T_child_joint, moved, coordinate)
        parent, T_parent_joint = child, IDENTITY


def _from_zero(motion: Motion) -> tuple[Pose, Motion | None]:
    """The place that a motion begins at, and the motion from there; None if it stands still."""
    function = motion.function
    if function == ITSELF:
        return IDENTITY, motion
    if not motion.is_fixed and function != linear(1.0, motion.way(0.0)):
        return IDENTITY, motion
    return fixed_pose(motion), None if motion.is_fixed else replace(motion, function=ITSELF)


def fixed_pose(motion: Motion) -> Pose:
    """Return the pose that a motion makes where its coordinate is 0."""
    way = motion.way(0.0)
    if motion.kind == "rotation":
        return Transform(axis_rotation(motion.axis, way), (0.0, 0.0, 0.0)).pose()
    x, y, z = (way * component for component in motion.axis)
    return Pose((x, y, z))
