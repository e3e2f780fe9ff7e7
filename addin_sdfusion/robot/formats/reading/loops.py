"""Construction of loop joints from constraints between two links."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from ...model.loop import LoopJoint
from ...model.pose import Pose
from ...model.robot import WORLD
from .xml import Node

End = tuple[str, Pose]
"""Name of a link, and a frame in it."""


def loop_joint(
    node: Node, name: str, type_: Literal["ball", "fixed"], ends: tuple[End, End],
    bodies: Mapping[str, str],
) -> LoopJoint | None:  # fmt: skip
    """Return the loop joint of a constraint, or None if both links belong to one rigid body.

    Args:
        node: Element of the constraint.
        name: Name of the joint.
        type_: `ball` for coincident points, `fixed` for coincident frames.
        ends: The coincident frames.
        bodies: Rigid body of each link; see `rigid_bodies`.
    """
    (parent, T_parent_joint), (child, T_child_joint) = ends
    if child == WORLD:
        (child, T_child_joint), (parent, T_parent_joint) = ends
    if bodies.get(parent) == bodies.get(child):
        problem = f"{name!r} connects {parent!r} and {child!r}, which are one rigid body; ignored"
        node.warning("loop-of-no-length", problem)
        return None
    return LoopJoint(
        name,
        parent,
        child,
        type_,
        T_parent_joint=T_parent_joint,
        T_child_joint=T_child_joint,
    )
