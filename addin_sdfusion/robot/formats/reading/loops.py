"""Construction of loop joints from constraints between two links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ...model.loop import LoopJoint
from ...model.robot import WORLD
from ...transforms.loop_points import LoopPoint, join_points
from .xml import Node


def closing_joints(
    parts: Sequence[LoopJoint | LoopPoint], nodes: Mapping[str, Node], bodies: Mapping[str, str]
) -> tuple[tuple[LoopJoint, ...], tuple[LoopPoint, ...]]:
    """Return loop joints, and the conditions that do not form one.

    Args:
        parts: Loop joints and conditions on points, in the order of the file.
        nodes: Element of each part, by name.
        bodies: Rigid body of each link; see `rigid_bodies`.
    """
    joints = []
    loops, others = join_points(parts)
    for loop in loops:
        if bodies.get(loop.parent) == bodies.get(loop.child):
            problem = (
                f"{loop.name!r} connects {loop.parent!r} and {loop.child!r}, which are one rigid "
                "body; ignored"
            )
            nodes[loop.name].warning("loop-of-no-length", problem)
        else:
            joints.append(_reversed(loop) if loop.child == WORLD else loop)
    return tuple(joints), others


def _reversed(loop: LoopJoint) -> LoopJoint:
    """Return the same loop joint with exchanged links."""
    return replace(
        loop,
        parent=loop.child,
        child=loop.parent,
        axes=loop.axes[::-1],
        T_parent_joint=loop.T_child_joint,
        T_child_joint=loop.T_parent_joint,
    )
