"""SDF representation of joints: single joints, universal joints, and chains of single joints.

SDF has no joint with three motions and arbitrary coordinates (its ball has no coordinates). Such a
joint is written as a chain of single joints with massless links. The plugin lists the joints of the
chain, so that they are merged again when the file is read.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ...model.joint import Coordinate, Joint, Motion, MotionKind
from ...model.loop import LoopJoint, LoopType
from ...model.pose import IDENTITY, Pose
from ...model.robot import WORLD, Robot
from ...transforms.joint_chains import Names


@dataclass(frozen=True, slots=True)
class SdfJoint:
    """Joint element of an SDF file.

    Attributes:
        name, type: Name and type in the file.
        parent, child: Links in the file.
        motions: None, one, or two for a universal joint.
        coordinates: One for each motion.
        T_parent_joint, T_child_joint: As in `Joint`.
        between: Whether the child is a massless link that is not part of the robot.
        closes_loop: Whether it is a loop joint, which has no coordinates.
    """

    name: str
    type: str
    parent: str
    child: str
    motions: tuple[Motion, ...]
    coordinates: tuple[Coordinate, ...]
    T_parent_joint: Pose
    T_child_joint: Pose
    between: bool = False
    closes_loop: bool = False


def sdf_joints(robot: Robot) -> dict[str, list[SdfJoint]]:
    """Return the joint elements of each joint of a robot, by joint name."""
    joints = [joint.name for joint in robot.joints]
    names = Names([WORLD, *joints, *(link.name for link in robot.links)])
    return {joint.name: list(_split(joint, names)) for joint in robot.joints}


def sdf_loops(robot: Robot) -> list[SdfJoint]:
    """Return the loop joints whose type SDF supports."""
    return [
        SdfJoint(
            loop.name,
            loop.type,
            loop.parent,
            loop.child,
            tuple(Motion(KINDS[loop.type], axis) for axis in loop.axes),
            tuple(Coordinate("") for _ in loop.axes),
            loop.T_parent_joint,
            loop.T_child_joint,
            closes_loop=True,
        )
        for loop in robot.loops
        if loop.type in KINDS
    ]


def loops_in_plugin(robot: Robot) -> list[LoopJoint]:
    """Return the loop joints whose type SDF does not support."""
    return [loop for loop in robot.loops if loop.type not in KINDS]


def is_chained(joint: Joint) -> bool:
    """Return whether a joint is written as a chain of joint elements."""
    return len(joint.motions) > 1 and joint.type != "universal"


def needs_plugin(joint: Joint) -> bool:
    """Return whether the plugin must describe a joint, because SDF's axes cannot hold all data."""
    return (
        not joint.is_plain
        or len(joint.motions) > 1
        or any(
            c.name != joint.name or c.actuated or c.initial or not has_one_effort(c)
            for c in joint.coordinates
        )
        or any(c.armature or c.limit_force for c in joint.coordinates)
    )


def has_one_effort(coordinate: Coordinate) -> bool:
    """Return whether the motor limits are symmetric, as with an effort in SDF."""
    return coordinate.tau_min == -coordinate.tau_max and coordinate.tau_max >= 0.0


def _split(joint: Joint, names: Names) -> Iterator[SdfJoint]:
    groups = [joint.motions] if not is_chained(joint) else [(motion,) for motion in joint.motions]
    parent, T_parent_joint = joint.parent, joint.T_parent_joint
    for k, motions in enumerate(groups, start=1):
        last = k == len(groups)
        child = joint.child if last else names.unique(f"{joint.name}_link_{k}")
        yield SdfJoint(
            joint.name if len(groups) == 1 else names.unique(f"{joint.name}_{k}"),
            joint.type if joint.is_plain and not is_chained(joint) else _type(motions),
            parent,
            child,
            motions,
            tuple(_axis_coordinate(joint, joint.motions.index(motion)) for motion in motions),
            T_parent_joint,
            joint.T_child_joint if last else IDENTITY,
            between=not last,
        )
        parent, T_parent_joint = child, IDENTITY


def _type(motions: tuple[Motion, ...]) -> str:
    return _TYPES[motions[0].kind] if motions else "fixed"


def _axis_coordinate(joint: Joint, place: int) -> Coordinate:
    """Return the coordinate of the axis of a motion; an empty one if another axis has it."""
    index = joint.motions[place].coordinate
    is_here = not joint.motions[place].is_fixed and joint.main_motion(index) == place
    return joint.coordinates[index] if is_here else Coordinate("")


KINDS: dict[LoopType, MotionKind] = {
    "fixed": "rotation",
    "revolute": "rotation",
    "prismatic": "translation",
    "universal": "rotation",
    "ball": "rotation",
}
"""Loop joint types in SDF, and the kind of their motions."""

_TYPES = {"rotation": "revolute", "translation": "prismatic"}
