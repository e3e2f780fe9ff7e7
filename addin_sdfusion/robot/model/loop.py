"""Loop joints: those that close a loop between two links which the tree already holds."""

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
"""How many axes each type has."""


@dataclass(frozen=True, slots=True)
class LoopJoint:
    """A joint without coordinates, which holds where two links of the tree can be.

    In the joint frame on the parent, the joint frame on the child may be moved by

        fixed        nothing
        revolute     a rotation about the axis
        prismatic    a translation along it
        cylindrical  both
        universal    a rotation about the first axis, and one about the second, orthogonal to it
        ball         any rotation
        planar       translations across the axis, and a rotation about it

    Attributes:
        name: Its name, unique among the joints.
        parent: One link, or `WORLD`.
        child: The other.
        type: What it leaves free.
        axes: Unit vectors in the joint frame, as many as the type has.
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
    """Type and axes of the loop joint that leaves these motions free; None if there is none."""
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
