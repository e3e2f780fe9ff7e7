"""Conversion of joints with several motions to chains of single-motion joints.

Formats with one motion per joint use these functions. A joint with n motions becomes n joints, in
the order of its motions, with n - 1 massless links `<joint>_1`, `<joint>_2`, ... between them. A
moving joint has the name of its coordinate. A fixed joint keeps its name, or has the name
`<joint>_<k>` in a chain. A constant offset of a motion becomes part of the joint frame. If a name
already exists, underscores or a number are appended.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from ..model.function import ITSELF, linear
from ..model.joint import Coordinate, Joint, Motion
from ..model.pose import IDENTITY, Pose
from ..model.robot import WORLD, Robot
from ..model.rotations import compose
from ..model.transform import motion_transform

_MAX_UNDERSCORES = 8
"""Maximum number of underscores appended to a name."""


class Names:
    """Generator of unique names, which appends underscores or a number to existing names."""

    def __init__(self, used_names: Iterable[str] = ()) -> None:
        self._used = set(used_names)
        self._numbers: Counter[str] = Counter()

    def unique(self, name: str) -> str:
        """Return the name, with a suffix if the name already exists."""
        free = name
        for _ in range(_MAX_UNDERSCORES):
            if free in self._used:
                free += "_"
        while free in self._used:
            self._numbers[name] += 1
            free = f"{name}_{self._numbers[name]}"
        self._used.add(free)
        return free


@dataclass(frozen=True, slots=True)
class SingleJoint:
    """A joint with one motion, or a fixed joint.

    Attributes:
        name: Unique among the single joints.
        parent, child: Links of the robot, `WORLD`, or massless links between single joints.
        T_parent_joint: Pose of the joint frame in the parent's frame.
        T_child_joint: Pose of the frame after the motion in the child's frame.
        motion: Motion, or None for a fixed joint.
        coordinate: Coordinate that drives the motion, or None for a fixed joint.
    """

    name: str
    parent: str
    child: str
    T_parent_joint: Pose
    T_child_joint: Pose
    motion: Motion | None = None
    coordinate: Coordinate | None = None

    def joint(self, name: str) -> Joint:
        """Return the joint as a `Joint` with another name."""
        motions = () if self.motion is None else (replace(self.motion, coordinate=0),)
        coordinates = () if self.coordinate is None else (self.coordinate,)
        frames = self.T_parent_joint, self.T_child_joint
        return Joint(name, self.parent, self.child, motions, coordinates, *frames)


def single_joints(robot: Robot, *, keep_functions: bool = False) -> list[SingleJoint]:
    """Return the joints of a robot as chains of single joints, parents first.

    Args:
        keep_functions: Whether all motions keep their functions, including constant ones. Then the
            main motion of a coordinate has the coordinate's name; others are `<joint>_<k>`.
    """
    links = Names([WORLD, *(link.name for link in robot.links)])
    joints = Names(coordinate.name for coordinate in robot.all_coordinates)
    return [
        single for joint in robot.joints for single in _split(joint, links, joints, keep_functions)
    ]


def _split(
    joint: Joint, links: Names, joints: Names, keep_functions: bool
) -> Iterator[SingleJoint]:
    parent, T_parent_joint = joint.parent, joint.T_parent_joint
    if not joint.motions:
        name = joints.unique(joint.name)
        yield SingleJoint(name, parent, joint.child, T_parent_joint, joint.T_child_joint)
    for k, motion in enumerate(joint.motions, start=1):
        last = k == len(joint.motions)
        child = joint.child if last else links.unique(f"{joint.name}_{k}")
        T_child_joint = joint.T_child_joint if last else IDENTITY
        T_joint_zero, moved = (IDENTITY, motion) if keep_functions else _from_zero(motion)
        T_parent_joint = (
            T_parent_joint if T_joint_zero == IDENTITY else (compose(T_parent_joint, T_joint_zero))
        )
        if moved is None:
            name = joints.unique(f"{joint.name}_{k}")
            yield SingleJoint(name, parent, child, T_parent_joint, T_child_joint)
        else:
            coordinate = joint.coordinates[motion.coordinate]
            is_other = keep_functions and joint.main_motion(motion.coordinate) != k - 1
            name = joints.unique(f"{joint.name}_{k}") if is_other else coordinate.name
            yield SingleJoint(name, parent, child, T_parent_joint, T_child_joint, moved, coordinate)
        parent, T_parent_joint = child, IDENTITY


def _from_zero(motion: Motion) -> tuple[Pose, Motion | None]:
    """Split a motion into a constant pose and the motion without offset, None if constant."""
    function = motion.function
    if function == ITSELF:
        return IDENTITY, motion
    if not motion.is_fixed and function != linear(1.0, motion.displacement(0.0)):
        return IDENTITY, motion
    return fixed_pose(motion), None if motion.is_fixed else replace(motion, function=ITSELF)


def fixed_pose(motion: Motion) -> Pose:
    """Return the pose of a motion at coordinate 0."""
    return motion_transform(motion.kind, motion.axis, motion.displacement(0.0)).pose()
