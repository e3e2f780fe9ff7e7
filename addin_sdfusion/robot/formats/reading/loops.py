"""Constraints between two links as loop joints: points held together, links welded."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from ...model.loop import LoopJoint
from ...model.pose import Pose
from ...model.robot import WORLD
from .xml import Node

End = tuple[str, Pose]
"""A link, and a frame in it."""


def hold_together(
    node: Node, name: str, type_: Literal["ball", "fixed"], ends: tuple[End, End],
    bodies: Mapping[str, str],
) -> LoopJoint | None:  # fmt: skip
    """Return the loop joint of a constraint; None, with a finding, where its links are one body.

    Args:
        node: Its element.
        name: What the joint is called.
        type_: Whether it holds two points together, or two frames.
        ends: The frames that coincide.
        bodies: Of each link, the one that it is fixed to; see `rigid_bodies`.
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
