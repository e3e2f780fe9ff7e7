"""Constraints between two links as loop joints: points held together, links welded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from ..checks.loops import rigid_bodies
from ..model.joint import Joint
from ..model.loop import LoopJoint
from ..model.pose import Pose
from ..model.robot import WORLD
from .xml import Node

End = tuple[str, Pose]
"""A link, and a frame in it."""


def hold_together(
    node: Node, name: str, type_: Literal["ball", "fixed"], ends: tuple[End, End],
    joints: Sequence[Joint],
) -> LoopJoint | None:  # fmt: skip
    """The loop joint of a constraint; None, with a finding, where its links are one body.

    Args:
        node: Its element.
        name: What the joint is called.
        type_: Whether it holds two points together, or two frames.
        ends: The frames that coincide.
        joints: The tree, parents first.
    """
    (parent, T_parent_joint), (child, T_child_joint) = ends
    if child == WORLD:
        (child, T_child_joint), (parent, T_parent_joint) = ends
    bodies = rigid_bodies(joints)
    if bodies.get(parent) == bodies.get(child):
        problem = f"{parent!r} and {child!r}, which {name!r} holds together, are one body; left out"
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
