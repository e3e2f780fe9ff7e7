"""Joints of an SDF model that close loops: those to a link which another joint carries already."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...model.joint import Coordinate, Joint
from ...model.loop import LoopJoint, loop_type
from ..reading.xml import Node
from .read_joints import Model, read_joint


def split_loops(nodes: Sequence[Node], model: Model) -> tuple[list[Joint], list[LoopJoint]]:
    """Return the joints of the tree and those that close loops.

    Of several joints with the same child, the first in the file carries it, but one whose range is
    0 only if there is no other. A loop joint with such a range is fixed.

    Args:
        nodes: The joint elements.
        model: What they are read with.
    """
    read = [(read_joint(node, model), node) for node in nodes]
    carriers: dict[str, Joint] = {}
    for joint, _ in sorted(read, key=lambda item: _is_held(item[0])):
        if joint.parent != joint.child:
            carriers.setdefault(joint.child, joint)
    loops = [
        _loop(joint, node, carriers[joint.child])
        for joint, node in read
        if carriers.get(joint.child, joint) is not joint
    ]
    names = {id(joint) for joint in carriers.values()}
    return [j for j, _ in read if id(j) in names or j.child not in carriers], loops


def _is_held(joint: Joint) -> bool:
    """Return whether it has a range, of a single value: 0."""
    return bool(joint.motions) and all(c.lower == c.upper == 0.0 for c in joint.coordinates)


def _loop(joint: Joint, node: Node, carrier: Joint) -> LoopJoint:
    motions = joint.motions
    if _is_held(joint):
        motions = ()
        problem = f"closes a loop, as {carrier.name!r} carries {joint.child!r}; its range is 0: "
        node.warning("loop-joint-held", f"{problem}it holds as a fixed joint does")
    lost = [what for what in _WORDS if any(_has(c, what) for c in joint.coordinates)]
    if motions and lost:
        problem = f"closes a loop, and has no coordinate then: its {', '.join(lost)} are left out"
        node.warning("loop-joint-forces", problem)
    kind = loop_type(motions)
    assert kind is not None, joint.name  # SDF's types all can
    return LoopJoint(
        joint.name, joint.parent, joint.child, *kind, joint.T_parent_joint, joint.T_child_joint
    )


_WORDS = ("limits", "damping", "stiffness", "friction")


def _has(c: Coordinate, what: str) -> bool:
    if what == "limits":
        return math.isfinite(c.lower) or math.isfinite(c.upper)
    return bool(getattr(c, what))
