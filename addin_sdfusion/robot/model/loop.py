"""Loop joints, which close a loop between two links of the joint tree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from .joint import Motion, joint_type
from .pose import IDENTITY, Pose, Vector3

LoopType = Literal["fixed", "revolute", "prismatic", "cylindrical", "universal", "ball", "planar"]

LOOP_TYPES: tuple[LoopType, ...] = get_args(LoopType)

AXES: dict[LoopType, int] = {
    "fixed": 0,
    "revolute": 1,
    "prismatic": 1,
    "cylindrical": 1,
    "universal": 2,
    "ball": 0,
    "planar": 1,
}
"""Number of axes of each type."""


@dataclass(frozen=True, slots=True)
class LoopJoint:
    """A joint without coordinates that constrains the relative pose of two links of the tree.

    The joint frame on the child can move relative to the joint frame on the parent by

        fixed        no motion
        revolute     a rotation about the axis
        prismatic    a translation along the axis
        cylindrical  a rotation about and a translation along the axis
        universal    rotations about the first axis and about the second axis, orthogonal to it
        ball         any rotation
        planar       translations normal to the axis and a rotation about it

    Attributes:
        name: Name, unique among the joints.
        parent: First link, or `WORLD`.
        child: Second link.
        type: Type, which defines the free motions.
        axes: Unit vectors in the joint frame, see `AXES` for their number.
        T_parent_joint: Pose of the joint frame in the parent link's frame.
        T_child_joint: Pose of the joint frame in the child link's frame.
    """

    name: str
    parent: str
    child: str
    type: LoopType = "fixed"
    axes: tuple[Vector3, ...] = ()
    T_parent_joint: Pose = IDENTITY
    T_child_joint: Pose = IDENTITY


def loop_type(motions: tuple[Motion, ...]) -> tuple[LoopType, tuple[Vector3, ...]] | None:
    """Return type and axes of the loop joint that allows these motions, or None."""
    kind = joint_type(motions)
    axes = tuple(motion.axis for motion in motions)
    if kind == "fixed" or kind == "ball":
        return kind, ()
    if kind == "revolute" or kind == "prismatic" or kind == "universal":
        return kind, axes
    if kind == "planar":
        return kind, axes[2:]
    kinds = {motion.kind for motion in motions}
    if len(motions) == 2 and len(kinds) == 2 and axes[0] == axes[1]:
        return "cylindrical", axes[:1]
    return None
